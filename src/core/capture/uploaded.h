// A capture on a device.
#ifndef FFP_CAPTURE_UPLOADED_H
#define FFP_CAPTURE_UPLOADED_H

#include "core/capture/capture.h"

// A copy whose coverage, photographs and patterns are in the memory of the device that the thread works on
// (core/base/device.h), the latter two of the n patterns given; NULL: of all, and the true maps. Everything
// else stays on the host; Gray codes' positions are not in it. Release with ffp_capture_free while working
// there.
FfpCapture ffp_capture_uploaded(const FfpCapture *host, const int *patterns, int n);

#endif
