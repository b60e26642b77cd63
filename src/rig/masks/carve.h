// A visual hull (Laurentini 1994) that background, free space and light carve.
#ifndef FFP_RIG_CARVE_H
#define FFP_RIG_CARVE_H

#include "rig/masks/free_space.h"
#include "rig/masks/steps.h"
#include "rig/masks/voxels.h"

typedef struct FfpHull {
    const FfpCapture *capture;    // its sphere is the hull's
    const FfpCompared *compared;  // [n_views]
    unsigned char *const *shaded; // [n_views][height*width] known background in the object's shadow
    const FfpFreeSpace *space;
    FfpVoxels voxels;     // owned, and
    FfpDepthMap *shadows; // [n_views] what each projector sees of the hull itself
} FfpHull;

// The sphere around what the views show as object becomes the capture's; false when no view shows any.
// Poses are known.
bool ffp_hull_bounds(FfpCapture *capture, const FfpCompared *compared);

// Carves from scratch. A point is carved away where one view shows lit stage or stage in the object's shadow,
// or two show dim stage; where two cameras or projectors see through it; where fewer than half of the views
// have it in their pictures; or where views show it unlit, though the hull casts no shadow on it: at least
// two more than show object there.
FfpHull ffp_hull_new(const FfpCapture *capture, const FfpCompared *compared, unsigned char *const *shaded,
                     const FfpFreeSpace *space);
void ffp_hull_free(FfpHull *hull);

// How far a pixel's ray runs through the hull, in units of the sphere's radius; `pixel` counts row by row.
double ffp_hull_length(const FfpHull *hull, int view, size_t pixel);

#endif
