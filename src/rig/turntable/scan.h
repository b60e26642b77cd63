// How far away the turntable is, which silhouettes do not tell: only at the right distance do points exist
// that had, at several stops, the colours that the projector sent there.
#ifndef FFP_RIG_SCAN_H
#define FFP_RIG_SCAN_H

#include "core/capture/capture.h"
#include "rig/turntable/outline.h"

typedef struct FfpScan {
    double factor; // on the axis' point: where the error is least
    double error;  // mean square of the differences between colours, at the best depth of each pixel
    double chance; // the same as the median over all distances tried
    int tried;     // distances at which the projector reaches the object; 0: nothing holds
} FfpScan;

// Tries factors from `low` to `high`. The capture has pictures under black, white and `active`; its views'
// cameras are alike, and its first view's projector stands as the camera sees it (pose: projector to camera).
FfpScan ffp_scan_distance(const FfpCapture *capture, int active, const FfpOutlines *outlines,
                          const FfpAxis *axis, double low, double high);

#endif
