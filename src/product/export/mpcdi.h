// MPCDI (VESA, Multiple Projection Common Data Interchange): warps of several projectors in one file for
// media servers. A ZIP archive of mpcdi.xml and, for each projector, a warp (PFM) and a mask (PNG).
// Version 2.0 names things otherwise than 1.0, which many readers still ask for: there is a file of each.
//
// Profile "2d": a region's warp has, for each of its pixels, the place in the content, u to the right and v
// up from the lower left corner, in [0,1], and NaN where there is none. Rows of a PFM begin at the bottom.
#ifndef FFP_EXPORT_MPCDI_H
#define FFP_EXPORT_MPCDI_H

#include <stdint.h>
#include "core/base/file.h"
#include "core/capture/capture.h"

typedef struct FfpArchived { // a file in the archive
    char name[32];
    uint32_t crc, packed, size, at;
} FfpArchived;

typedef struct FfpMpcdi {
    FfpOutput out[2];      // of version 1.0, 2.0
    const FfpView **views; // one a region
    int n_views;
    FfpArchived *files;
    int n_files;
} FfpMpcdi;

// True if an archive can hold the warps of these views: it ends at 4 GB.
bool ffp_mpcdi_holds(const FfpView *const *views, int n_views);
// "PATH.mpcdi" of version 2.0, and "PATH-1.0.mpcdi".
bool ffp_mpcdi_open(FfpMpcdi *mpcdi, const char *path, FfpError *err);
// A region: the view's projector, named as the view, which stays the caller's until the commit. `map`:
// ffp_view_maps' projector_to_camera [h,w,3]. The mask is white where it has a place.
bool ffp_mpcdi_add(FfpMpcdi *mpcdi, const FfpView *view, const FfpImage *map, FfpError *err);
// Views of the same camera share a buffer, the content of its picture's size, which each of them covers.
bool ffp_mpcdi_commit(FfpMpcdi *mpcdi, FfpError *err);
void ffp_mpcdi_abort(FfpMpcdi *mpcdi); // safe after the commit, and of a struct of zeros

#endif
