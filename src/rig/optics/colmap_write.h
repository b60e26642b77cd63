// COLMAP's text model (colmap.github.io/format.html) as a file for other programs, and for `import`.
#ifndef FFP_RIG_COLMAP_WRITE_H
#define FFP_RIG_COLMAP_WRITE_H

#include <stddef.h>
#include "core/base/rigid.h"
#include "core/capture/optics.h"

#define FFP_COLMAP_PROJECTOR "calib" // the picture that stands for the projector

typedef struct FfpColmapImage {
    const char *name; // of its file
    int camera;       // index
    FfpRigid pose;    // world to camera
} FfpColmapImage;

typedef struct FfpColmapPoint {
    double at[3];
    unsigned char colour[3];
    double error; // pixels
} FfpColmapPoint;

typedef struct FfpColmapModel {
    const FfpOptics *cameras;     // as RADIAL where one focal length and k1, k2 are all, otherwise as
    const FfpColmapImage *images; // FULL_OPENCV
    const FfpColmapPoint *points; // without tracks
    int n_cameras, n_images;
    size_t n_points;
} FfpColmapModel;

// True if a picture, "left/calib.jpg", is called so.
bool ffp_colmap_is_called(const char *name, const char *stem);
// cameras.txt, images.txt and points3D.txt into a folder that exists. Ids count from 1.
bool ffp_colmap_write(const FfpColmapModel *model, const char *folder, FfpError *err);

#endif
