// A capture whose pictures are small enough to be matched quickly.
#ifndef FFP_CAPTURE_SMALL_H
#define FFP_CAPTURE_SMALL_H

#include "core/capture/capture.h"

// The same views with coverage and the pictures under black, white and `active` alone, all of the size that
// the first view's pictures have when neither side is longer than some 180 pixels. Patterns are the capture's
// own. Free by ffp_capture_reduced_free.
FfpCapture ffp_small_new(const FfpCapture *capture, int active);

#endif
