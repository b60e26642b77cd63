// Which pixels get a Gaussian, in what blocks, and between a Gaussian's raw numbers and its place in the
// arrays.
#ifndef FFP_NETWORK_PIXELS_H
#define FFP_NETWORK_PIXELS_H

#include "network/head.h"
#include "network/splat.h"

typedef struct FfpPixels {
    int64_t count;
    FfpPixelBase *base; // [count]
    real *raw;          // [count, numbers]
} FfpPixels;

// Lists the pixels (all, or those of coverage > 0 in the residual form) into run->pixel and head->place and
// head->blocks, and fills the bases. Memory from run->arena; head->inputs must be set.
void ffp_pixels_list(FfpPixels *pixels, FfpHead *head, FfpRun *run, const FfpModelConfig *config,
                     const FfpCapture *capture, const FfpStart *start, int views);

// raw -> run->gaussians, run->t. False when a number is not finite.
bool ffp_pixels_splat(const FfpPixels *pixels, FfpRun *run, const FfpModelConfig *config,
                      const FfpCapture *capture);
// draw [block->count, numbers] of one block from the gradients of the Gaussians.
void ffp_pixels_splat_backward(real *draw, const FfpPixels *pixels, const FfpHeadBlock *block,
                               const FfpModelConfig *config, const FfpGaussians *grad, const real *grad_t);

#endif
