// The numbers that the network sees of each pixel.
#ifndef FFP_NETWORK_INPUTS_H
#define FFP_NETWORK_INPUTS_H

#include "network/network.h"

// Channels of a pixel, in this order:
//   0-8    black, white, active: sRGB * 2 - 1
//   9-11   unit direction of the pixel's ray; 12-14 the ray's point nearest to the origin
// and with match_input, all zero where coverage is zero:
//   15     distance from that nearest point to the start's point, along the ray
//   16-20  confidence, lit, coverage, agreement, violation
//   21-23  normal; 24-26 albedo, 27-29 ambient: sRGB * 2 - 1
enum { FFP_PLAIN_CHANNELS = 15, FFP_START_CHANNELS = 15, FFP_RAY_CHANNEL = 9 };

// Checks that the capture and the start fit the model: views, images, sizes. Errors name the view.
bool ffp_inputs_check(const FfpModelConfig *config, const FfpCapture *capture, const FfpStart *start,
                      int views, int active, FfpError *err);

// out [tokens, patch, patch, channels]: tokens view by view, inside a view in raster order. start may be NULL
// without match_input.
void ffp_inputs(real *out, const FfpModelConfig *config, const FfpCapture *capture, const FfpStart *start,
                int views, int active);

#endif
