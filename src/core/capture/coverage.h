// Estimates from a capture's pictures alone: the object's share of each pixel, and the projector's intensity.
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

// True if a view's mask is used: always with `mask_first`, otherwise if no picture has an alpha channel.
// `alphas` [n_patterns]: alpha of each picture, .data NULL where it has none.
bool ffp_wants_mask(const FfpCapture *capture, const FfpImage *alphas, bool mask_first);

// Fills view->coverage: from the `mask` (of the camera's size; it is emptied), by which the pictures are put
// over black unless it is already `applied`; if its .data is NULL, from the alphas, or guessed.
FfpCoverageSource ffp_cover_view(const FfpCapture *capture, FfpView *view, const FfpImage *alphas,
                                 FfpImage *mask, bool applied);

// For a projector of unknown intensity: the scalar I that puts the 95th percentile of the apparent albedo
// pi d^2 (white - black) / I of lit pixels at 0.8, where d is the projector's distance to the object's
// centre. Fails if white brightens nothing.
bool ffp_estimate_intensity(FfpCapture *capture, const char *file, FfpError *err);

#endif
