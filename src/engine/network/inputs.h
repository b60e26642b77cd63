// The network's inputs for each pixel.
#ifndef FFP_NETWORK_INPUTS_H
#define FFP_NETWORK_INPUTS_H

#include "engine/network/network.h"

// Channels of a pixel, in this order:
//   0-8    black, white, active: sRGB * 2 - 1
//   9-11   unit direction of the pixel's ray; 12-14 the ray's point nearest to the origin
// and with match_input, all zero where coverage is zero:
//   15     distance from that nearest point to the start's point, along the ray
//   16-20  confidence, lit, coverage, agreement, violation
//   21-23  normal; 24-26 albedo, 27-29 ambient: sRGB * 2 - 1
// and with context_inputs, for the pixel MLP alone, all zero where the context is the capture itself:
//   log2 of the context's pixel side against the capture's, up to 0.68; how far behind the context's surface
//   the start's point lies, in four of the context's footprints, in [-1,1]
enum { FFP_PLAIN_CHANNELS = 15, FFP_INITIALISATION_CHANNELS = 15, FFP_CONTEXT_CHANNELS = 2 };

typedef struct FfpInputSource { // what the numbers are of
    const FfpCapture *capture;
    const FfpInitialisation *start; // NULL: none
    int views, active;              // the first views; the pattern
} FfpInputSource;

// Checks that the source is complete: views of one size with their images, and a start of that size if the
// model needs one. Errors name the view.
bool ffp_inputs_check(const FfpModelConfig *config, const FfpInputSource *source, FfpError *err);

// out [channels] of pixel (view * height + y) * width + x.
void ffp_pixel_inputs(real *out, const FfpModelConfig *config, const FfpInputSource *source, int64_t pixel);

// out [tokens, patch, patch, channels]: tokens view by view, inside a view in raster order. Sides must be
// multiples of the patch.
void ffp_inputs(real *out, const FfpModelConfig *config, const FfpInputSource *source);

#endif
