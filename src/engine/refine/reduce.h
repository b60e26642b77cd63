// A capture with smaller pictures: fewer pixels, and no more of them than the object needs.
#ifndef FFP_REFINE_REDUCE_H
#define FFP_REFINE_REDUCE_H

#include "core/capture/capture.h"

// The capture as cameras with 1/side as many pixels a side (rounded up) would see it (core/capture/reduce.h),
// all cut to a window around the object: 16 pixels more on each side than what it covers, of one size for all
// views where their frames have it. With the photographs of the given patterns. Patterns are the given
// capture's own, which must outlive the result. Released by ffp_capture_reduced_free.
FfpCapture ffp_reduced(const FfpCapture *capture, const int *patterns, int n_patterns, int side);

#endif
