// A capture whose pictures are smaller.
#ifndef FFP_CAPTURE_REDUCE_H
#define FFP_CAPTURE_REDUCE_H

#include "core/capture/capture.h"

// The view with pictures of width x height: coverage and the photographs under the `n` given of n_patterns
// patterns, as the object's own linear radiance times its coverage, averaged over each pixel's area, or
// interpolated along a side that grows; positions in the projector averaged likewise where they are known; a
// camera that sees the same with so many pixels; the frame, rounded up. Of its own size: a copy. Truth maps
// and other pictures are left out (.data NULL); a photograph that the view lacks stays missing.
FfpView ffp_view_reduced(const FfpView *view, int n_patterns, const int *patterns, int n, int width,
                         int height);
void ffp_view_reduced_free(FfpView *view, int n_patterns);

// The first `views` views likewise. Patterns are the capture's own memory: it must outlive the result.
FfpCapture ffp_capture_reduced(const FfpCapture *capture, int views, const int *patterns, int n, int width,
                               int height);
// Pixels, of the widest camera.
int ffp_capture_widest(const FfpCapture *capture);
// All views, with all photographs, by the factor that makes the widest `width` pixels wide.
FfpCapture ffp_capture_narrowed(const FfpCapture *capture, int width);
void ffp_capture_reduced_free(FfpCapture *reduced); // not the patterns; safe on {0}

#endif
