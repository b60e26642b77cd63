// A pixel of a view: background, the light of the projector, and the share of it under a pattern.
#ifndef FFP_CAPTURE_PIXEL_H
#define FFP_CAPTURE_PIXEL_H

#include "core/capture/capture.h"

// Background in the pixel and all around it, within the picture; `coverage` [h,w].
bool ffp_is_background(const FfpImage *coverage, int x, int y);

// White adds 0.04 (linear radiance) to the pixel in every channel.
bool ffp_is_lit(const FfpCapture *capture, const FfpView *view, size_t pixel);

// The share of white's light in the photograph under a pattern, (photograph - black) / (white - black), per
// channel. False: the pixel is not lit, or white is near the camera's limit, which tells no ratio.
bool ffp_lit_ratio(const FfpCapture *capture, const FfpView *view, const FfpImage *photograph, size_t pixel,
                   real ratio[3]);

#endif
