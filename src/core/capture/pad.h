// Views of different sizes as views of one size.
#ifndef FFP_CAPTURE_PAD_H
#define FFP_CAPTURE_PAD_H

#include "core/capture/capture.h"

// The capture with all views as wide and as high as the widest and the highest, rounded up to a multiple of
// `multiple`. A smaller view gets black pixels of coverage 0 to the right and below, which leaves its
// intrinsics unchanged; frame_width and frame_height give the part that a camera saw. Padded views have
// the `n` pictures of these indices and the coverage, and no ground truth; all others borrow the capture's
// images, as do those of a capture that needs no padding. Release with ffp_padded_capture_free, passing the
// same capture again.
FfpCapture ffp_padded_capture(const FfpCapture *capture, const int *pictures, int n, int multiple);
void ffp_padded_capture_free(FfpCapture *padded, const FfpCapture *capture);

// In files, the sides of each view's pictures are whole patches of the shipped network; the part that the
// camera saw is at the upper left.
#define FFP_WHOLE_PATCH 8
FfpCamera ffp_whole_camera(const FfpCamera *camera);
// A copy of this view with all its images, padded with black of coverage 0; its frame is the part that the
// camera saw. Release with ffp_view_free.
FfpView ffp_whole_view(const FfpView *view, int n_patterns);
// The inverse, in place: crops the view to its frame.
void ffp_cut_to_frame(FfpView *view, int n_patterns);

#endif
