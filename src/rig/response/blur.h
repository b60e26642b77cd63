// How soft the projector's pictures are where they land.
#ifndef FFP_RIG_BLUR_H
#define FFP_RIG_BLUR_H

#include "core/capture/capture.h"

// The deviation, in pixels of the ideal projector, of the Gaussian through which the patterns explain their
// photographs best at the pixels whose place on them is known (FfpView.correspondence): the softness of both
// lenses, as far as the camera's pixels do not average it away. With several patterns one deviation for all.
// Held-out patterns are not looked at. 0: no pattern has edges there, or none is seen sharply enough to tell.
double ffp_fit_blur(const FfpCapture *capture);

#endif
