// Views of different sizes as views of one size.
#ifndef FFP_CAPTURE_PAD_H
#define FFP_CAPTURE_PAD_H

#include "core/capture/capture.h"

// The capture with all views as wide and as high as the widest and the highest, rounded up to a multiple of
// `multiple`. A smaller view gets black pixels of coverage 0 to the right and below, which leaves its
// intrinsics as they are, and says in frame_width and frame_height what of it a camera saw. Padded views have
// the `n` pictures of these indices and the coverage, and no truth; all others borrow what the capture has,
// as do those of a capture that needs no padding. Release with ffp_padded_capture_free, the same capture
// given again.
FfpCapture ffp_padded_capture(const FfpCapture *capture, const int *pictures, int n, int multiple);
void ffp_padded_capture_free(FfpCapture *padded, const FfpCapture *capture);

// In files each view's pictures have sides of whole patches of the shipped network; what the camera saw is
// their upper left part.
#define FFP_WHOLE_PATCH 8
FfpCamera ffp_whole_camera(const FfpCamera *camera);
// A view of its own with everything that this one has, filled up with black of coverage 0; its frame is what
// the camera saw. Release with ffp_view_free.
FfpView ffp_whole_view(const FfpView *view, int n_patterns);
// The way back, in place: the view's frame alone.
void ffp_cut_to_frame(FfpView *view, int n_patterns);

#endif
