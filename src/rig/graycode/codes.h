// Gray codes of a view into its correspondences.
#ifndef FFP_RIG_CODES_H
#define FFP_RIG_CODES_H

#include "rig/graycode/graycode.h"
#include "rig/optics/lens.h"

// Positions on the panel that the camera's pixels saw, map [h,w,3] of the photographs' size, as those of the
// pinhole camera's pixels in the ideal projector's picture: both lenses taken away. Trust is 1 or 0. `step`:
// FfpGrayReport.
FfpImage ffp_codes_rectify(const FfpImage *map, double step, const FfpOptics *camera,
                           const FfpCamera *pinhole, const FfpOptics *projector, const FfpCamera *ideal);

// The region of the photographs that shows what a pinhole's coverage shows, 1 inside it and 0 outside: each
// pixel is projected through the lens, at its width there. [height,width,1] of the camera's size.
FfpImage ffp_codes_region(const FfpImage *coverage, const FfpCamera *pinhole, const FfpOptics *camera);

// How a view's correspondences fit its devices' poses. Positions that camera and projector disagree about by
// more than OFF_MAX pixels lose their trust.
typedef struct FfpCodesFit {
    int known, kept; // pixels with a position before and after
    double off;      // median distance of the camera's rays from the positions, pixels of the projector
} FfpCodesFit;
FfpCodesFit ffp_codes_check(FfpView *view);

// The object's sphere, where the one estimated from poses and masks misses part of the surfaces that the
// codes tell of: around their middle, as far as they reach. True when it was moved.
bool ffp_codes_bounds(FfpCapture *capture);
// The bounds of a whole scene, and each view's range of depth, from the same surfaces; false: there are none.
bool ffp_codes_scene_bounds(FfpCapture *capture);

#endif
