// Space that is seen to be empty: light that reaches a surface, and is seen there, meets nothing on its way.
#ifndef FFP_RIG_FREE_SPACE_H
#define FFP_RIG_FREE_SPACE_H

#include "rig/masks/depth_map.h"

typedef struct FfpFreeSpace {
    int n_views;
    FfpDepthMap *cameras, *projectors; // [n_views] of the surfaces that a view's matching finds, owned
} FfpFreeSpace;

// Matches the photographs within the views' coverage, which need not be masked, with the pattern that all
// views have. The capture must outlive the result. False, and nothing is known, where there is no such
// pattern, or where pictures have different sizes.
bool ffp_free_space_new(FfpFreeSpace *space, const FfpCapture *capture);
void ffp_free_space_free(FfpFreeSpace *space); // safe on {0}

// How many of two witnesses see through a point, which must lie `margin` (world units) before what they see:
// the view's camera and its projector.
int ffp_free_space_votes(const FfpFreeSpace *space, int view, const real point[3], real margin);

#endif
