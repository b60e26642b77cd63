// Where the perceptual networks' features of two pictures are compared.
#ifndef FFP_CUDA_PERCEPTUAL_TAPS_H
#define FFP_CUDA_PERCEPTUAL_TAPS_H

#include "core/base/real.h"
#include "engine/cuda/loss_sums.h"

// Features [channels, 2, pixels] of prediction and target at a tap.
typedef struct FfpTapPair {
    const float *value;
    float *grad;       // [channels, pixels]; NULL: none wanted
    const float *head; // [channels]: LPIPS; NULL: the mean squared difference
    int channels, pixels;
} FfpTapPair;

unsigned ffp_cuda_tap_blocks(int pixels);
// The distance, in ffp_cuda_tap_blocks partial sums from sums.partial on, and grad = weight * gradient.
void ffp_cuda_tap(FfpPartials sums, const FfpTapPair *pair, real weight);

#endif
