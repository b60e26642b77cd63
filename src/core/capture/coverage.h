// What follows from a capture's pictures alone: the object's share of each pixel, and the projector's
// strength.
#ifndef FFP_CAPTURE_COVERAGE_H
#define FFP_CAPTURE_COVERAGE_H

#include "core/capture/manifest.h"

typedef enum FfpCoverageSource {
    FFP_COVERAGE_MASK,    // a mask file; the pictures are multiplied by it, as if it were their alpha
    FFP_COVERAGE_ALPHA,   // the alpha channel of the white picture, otherwise of the black one, otherwise of
                          // any
    FFP_COVERAGE_GUESSED, // the pixels that some picture shows brighter than the black one; the pictures
                          // are unchanged
    FFP_COVERAGE_NONE,    // the view has no pictures: 0 everywhere
} FfpCoverageSource;

// Whether a view's mask is looked at: always when it is `mask_first`, otherwise where no picture has an alpha
// channel. `alphas` [n_patterns]: alpha of each picture, .data NULL where it has none.
bool ffp_wants_mask(const FfpCapture *capture, const FfpImage *alphas, bool mask_first);

// Fills view->coverage: from the `mask` (of the camera's size, and emptied), which the pictures are put over
// black with unless that is `applied` already; where its .data is NULL from the alphas, or guessed.
FfpCoverageSource ffp_cover_view(const FfpCapture *capture, FfpView *view, const FfpImage *alphas,
                                 FfpImage *mask, bool applied);

// For a projector of unknown strength: the one scalar I that puts the 95th percentile of the apparent albedo
// pi d^2 (white - black) / I of lit pixels at 0.8, d being the projector's distance to the object's centre.
// Errors when white brightens nothing.
bool ffp_estimate_intensity(FfpCapture *capture, const char *file, FfpError *err);

#endif
