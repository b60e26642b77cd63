// Photographs of one view as they are compared: black, and what the other patterns add to it, smoothed.
#ifndef FFP_RIG_LAYERS_H
#define FFP_RIG_LAYERS_H

#include "core/capture/capture.h"

enum { FFP_LAYERS_MAX = FFP_PATTERNS_MAX };

typedef struct FfpLayers {
    int n, width, height;
    FfpImage of[FFP_LAYERS_MAX]; // black; what white adds; what others add. Linear, 3 channels
} FfpLayers;

// Of the patterns that are both in `images` and in `others` [n_patterns] of the capture. Freed as a whole.
FfpLayers *ffp_layers_new(const FfpCapture *capture, const FfpImage *images, const FfpImage *others);
void ffp_layers_free(FfpLayers *layers);

// The error to allow in a difference of two views of one thing: from what they differ by under black, where
// most pixels show the same.
double ffp_layers_noise(const FfpLayers *a, const FfpLayers *b);
// Variance of a difference: of noise, of light (some per cent: bounces, noise where it is bright) and of what
// a pixel's neighbours differ by.
double ffp_layers_variance(double noise, double light, double edge);

#endif
