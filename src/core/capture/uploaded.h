// A capture on a device.
#ifndef FFP_CAPTURE_UPLOADED_H
#define FFP_CAPTURE_UPLOADED_H

#include "core/capture/capture.h"

// A copy whose pictures, coverage, true maps and patterns are in the memory of the device that the thread
// works on (core/base/device.h); everything else stays on the host. Release with ffp_capture_free while
// working there.
FfpCapture ffp_capture_uploaded(const FfpCapture *host);

#endif
