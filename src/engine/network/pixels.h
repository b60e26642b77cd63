// Which pixels get a Gaussian, and between a Gaussian's raw numbers and its place in the arrays.
#ifndef FFP_NETWORK_PIXELS_H
#define FFP_NETWORK_PIXELS_H

#include "engine/network/head.h"
#include "engine/network/splat.h"

typedef struct FfpPixels {
    int64_t count;
    FfpPixelBase *base; // [count]
    real *raw;          // [count, numbers]
} FfpPixels;

// Of one pixel, what its formulas start from.
void ffp_pixel_base(FfpPixelBase *base, const FfpInputSource *source, int64_t pixel, bool residual);
int64_t ffp_pixels_all(const FfpInputSource *source); // pixels of the input views
// Those that get a Gaussian into pixel [ffp_pixels_all]; returns their number.
int64_t ffp_pixels_select(int64_t *pixel, const FfpModelConfig *config, const FfpInputSource *source);

// Lists the pixels (all, or those of coverage > 0 in the residual form) into run->pixel and fills the bases.
// Memory from run->arena.
void ffp_pixels_list(FfpPixels *pixels, FfpRun *run, const FfpModelConfig *config,
                     const FfpInputSource *source);

// raw -> run->gaussians, run->t. False when a number is not finite.
bool ffp_pixels_splat(const FfpPixels *pixels, FfpRun *run, const FfpModelConfig *config);
// draw [count, numbers] of the Gaussians from `first` on from all Gaussians' gradients.
void ffp_pixels_splat_backward(real *draw, const FfpPixels *pixels, int64_t first, int count,
                               const FfpModelConfig *config, const FfpGaussians *grad, const real *grad_t);

#endif
