// Two-dimensional convolution with ReLU, and max pooling, for the perceptual networks. Planes are
// [channels,height,width]. The networks are frozen: backward gives the gradient of the input only. Private to
// this room and its kernels.
#ifndef FFP_LOSS_CONV_H
#define FFP_LOSS_CONV_H

#include <stdbool.h>
#include <stddef.h>
#include "core/base/real.h"

typedef struct FfpConv {
    int in, out;             // channels
    int kernel, stride, pad; // square
    int width, height;       // of the input
} FfpConv;

// Of the output; 0: the input is too small.
FFP_FORMULA int ffp_conv_side(int side, int kernel, int stride, int pad) {
    const int span = side + 2 * pad - kernel;
    return span < 0 ? 0 : span / stride + 1;
}

// y = relu(w * x + bias) for `images` images, whose x and y are x_step and y_step values apart.
// w [out, in, kernel, kernel]; bias [out]. Allocates a strip of unfolded input per thread.
void ffp_conv2d_forward(real *y, size_t y_step, const real *x, size_t x_step, const real *w, const real *bias,
                        const FfpConv *conv, int images);
// One image: ADDS the gradient to dx; dy is masked in place where the ReLU was shut (y == 0).
void ffp_conv2d_backward(real *dx, real *dy, const real *y, const real *w, const FfpConv *conv);

typedef struct FfpPool {
    int channels, kernel, stride;
    bool round_up; // a last, clipped window where the sides do not divide evenly
    int width, height;
} FfpPool;

// Index, inside its plane, of the first largest value of the window at output (x,y).
FFP_FORMULA int ffp_pool_largest(const real *plane, const FfpPool *pool, int x, int y) {
    const int left = x * pool->stride, top = y * pool->stride;
    const int right = left + pool->kernel < pool->width ? left + pool->kernel : pool->width;
    const int bottom = top + pool->kernel < pool->height ? top + pool->kernel : pool->height;
    int best = top * pool->width + left;
    for (int v = top; v < bottom; v++)
        for (int u = left; u < right; u++)
            if (plane[v * pool->width + u] > plane[best]) best = v * pool->width + u;
    return best;
}

FFP_FORMULA int ffp_pool_side(int side, int kernel, int stride, bool round_up) {
    const int span = side - kernel + (round_up ? stride - 1 : 0);
    return span < 0 ? 0 : span / stride + 1;
}

void ffp_maxpool_forward(real *y, const real *x, const FfpPool *pool);
// ADDS to dx: each window's gradient goes to its first largest value.
void ffp_maxpool_backward(real *dx, const real *dy, const real *x, const FfpPool *pool);

#endif
