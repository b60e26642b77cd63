// A capture on a device.
#ifndef FFP_CAPTURE_UPLOADED_H
#define FFP_CAPTURE_UPLOADED_H

#include "core/capture/capture.h"

// A copy whose pictures, coverage, true maps and patterns are in the memory of what the thread works on
// (core/base/device.h); everything else stays the host's. Released by ffp_capture_free, by who works there.
FfpCapture ffp_capture_uploaded(const FfpCapture *host);

#endif
