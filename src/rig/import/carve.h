// A visual hull (Laurentini 1994) that only known background carves.
#ifndef FFP_RIG_CARVE_H
#define FFP_RIG_CARVE_H

#include "rig/import/stage.h"

typedef struct FfpHull {
    const FfpCapture *capture;    // its sphere is the hull's
    const FfpCompared *compared;  // [n_views]
    unsigned char *const *shaded; // [n_views][height*width] known background in the object's shadow
    unsigned char *solid;         // voxels, owned
} FfpHull;

// The sphere around what the views show as object becomes the capture's; false when no view shows any.
// Poses are known.
bool ffp_hull_bounds(FfpCapture *capture, const FfpCompared *compared);

// Carves from scratch. A point is carved away where one view shows lit stage or stage in the object's shadow,
// or two show any stage, or where less than 0.6 of the views that have it in their pictures show the object.
FfpHull ffp_hull_new(const FfpCapture *capture, const FfpCompared *compared, unsigned char *const *shaded);
void ffp_hull_free(FfpHull *hull);

// How far a pixel's ray runs through the hull, in units of the sphere's radius; `pixel` counts row by row.
double ffp_hull_length(const FfpHull *hull, int view, size_t pixel);

#endif
