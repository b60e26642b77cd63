// Convolution, ReLU and pooling of the perceptual networks on the GPU (engine/loss/conv.h on the CPU). A slot
// of activations is [channels, images, height, width] here, so that a product takes all images at once.
#ifndef FFP_CUDA_PERCEPTUAL_CONV_H
#define FFP_CUDA_PERCEPTUAL_CONV_H

#include <stdbool.h>
#include <stddef.h>
#include "engine/loss/conv.h"

#ifdef __cplusplus
extern "C" {
#endif

// Memory for unfolded input: [in * kernel * kernel, output pixels of a strip].
typedef struct FfpColumns {
    float *values;
    size_t capacity; // strips are as long as fit; one output pixel must
} FfpColumns;

// Numbers in the unfolded input of a convolution's whole output, of `images` images; 0 where nothing is
// unfolded.
size_t ffp_cuda_columns(const FfpConv *conv, int images);
// Products round their factors to TF32 (10 bits of mantissa) unless exact ones were asked for here: for
// tests.
void ffp_cuda_conv_exact(bool exact);
// y = w * x, neither bias nor ReLU yet.
void ffp_cuda_picture_conv_forward(float *y, const float *x, const float *w, const FfpConv *conv, int images,
                                   FfpColumns columns);
// The adjoint, of one image: dx = or += w^T * dy.
void ffp_cuda_picture_conv_backward(float *dx, const float *dy, const float *w, const FfpConv *conv, bool add,
                                    FfpColumns columns);
// y [channels, row] = relu(y + bias)
void ffp_cuda_bias_relu(float *y, const float *bias, int channels, size_t row);
// dy [channels, row] = 0 where y [channels, images, row] of the first image is 0.
void ffp_cuda_relu_backward(float *dy, const float *y, int channels, int images, size_t row);

void ffp_cuda_maxpool_forward(float *y, const float *x, const FfpPool *pool, int images);
// Of the first of `images` images in x: dx = or += .
void ffp_cuda_maxpool_backward(float *dx, const float *dy, const float *x, const FfpPool *pool, int images,
                               bool add);

#ifdef __cplusplus
}
#endif

#endif
