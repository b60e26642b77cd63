// How much of the projector's light is spread widely: by its lens, the camera's, and the material.
#ifndef FFP_RIG_SPREAD_H
#define FFP_RIG_SPREAD_H

#include "core/capture/capture.h"

typedef struct FfpSpread {
    real share[3]; // of the light, per channel
    real reach; // deviation of the Gaussian around each place, pixels of the ideal projector; 0: none found
    double before, after; // PSNR, dB, of photographs that had no part in the fit, without and with it
} FfpSpread;

// Photographs whose patterns are known are compared with black + (white - black) ((1 - share) p + share q):
// p is the pattern, which holds its blur, where the pixel's place on it is known
// (FfpView.correspondence), and q its mean within the reach.
// Held-out patterns are not looked at. Kept only where either half of the patterns explains the photographs
// under the other half better with it; there must be two patterns at least.
FfpSpread ffp_fit_spread(const FfpCapture *capture);

#endif
