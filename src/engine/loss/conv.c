#include "engine/loss/conv.h"
#include "engine/loss/kernels/kernels.h"

void ffp_conv2d_forward(real *y, size_t y_step, const real *x, size_t x_step, const real *w, const real *bias,
                        const FfpConv *conv, int images) {
    ffp_loss_kernels()->conv2d_forward(y, y_step, x, x_step, w, bias, conv, images);
}

void ffp_conv2d_backward(real *dx, real *dy, const real *y, const real *w, const FfpConv *conv) {
    ffp_loss_kernels()->conv2d_backward(dx, dy, y, w, conv);
}

void ffp_maxpool_forward(real *y, const real *x, const FfpPool *pool) {
    ffp_loss_kernels()->maxpool_forward(y, x, pool);
}

void ffp_maxpool_backward(real *dx, const real *dy, const real *x, const FfpPool *pool) {
    ffp_loss_kernels()->maxpool_backward(dx, dy, x, pool);
}
