// The loops of the losses that exist once for each CPU level (core/base/level.h).
#ifndef FFP_LOSS_KERNELS_KERNELS_H
#define FFP_LOSS_KERNELS_KERNELS_H

#include "core/base/level.h"
#include "core/image/image.h"
#include "engine/loss/conv.h"

// Of structural similarity (ssim.c).
enum { FFP_SSIM_RADIUS = 5, FFP_SSIM_TAPS = 2 * FFP_SSIM_RADIUS + 1 };
enum { FFP_SSIM_MOMENTS = 5, FFP_SSIM_SLOPES = 3 }; // a, b, aa, bb, ab; and by a, aa, ab

typedef struct FfpSsimWindow {
    int height, edge; // edge: values of padding on each side of a row
    int row;          // values in a row: width * channels
    int channels;
    real taps[FFP_SSIM_TAPS];
} FfpSsimWindow;

// moments [MOMENTS, height, row]: the products a, b, aa, bb, ab, blurred along the rows only.
typedef void FfpSsimMoments(const FfpSsimWindow *window, real *moments, const FfpImage *a, const FfpImage *b);
// Sums of the index per row into row_sums [height]; slopes [SLOPES, height, row] blurred along the rows, or
// NULL.
typedef void FfpSsimCompare(const FfpSsimWindow *window, double *row_sums, real *slopes, const real *moments);
// grad += scale (blur(slope_a) + 2 a blur(slope_aa) + b blur(slope_ab))
typedef void FfpSsimGradient(const FfpSsimWindow *window, const real *slopes, const FfpImage *a,
                             const FfpImage *b, real scale, FfpImage *grad);

// Those of conv.h.
typedef void FfpConvForward(real *y, size_t y_step, const real *x, size_t x_step, const real *w,
                            const real *bias, const FfpConv *conv, int images);
typedef void FfpConvBackward(real *dx, real *dy, const real *y, const real *w, const FfpConv *conv);
typedef void FfpPoolForward(real *y, const real *x, const FfpPool *pool);
typedef void FfpPoolBackward(real *dx, const real *dy, const real *x, const FfpPool *pool);

typedef struct FfpLossKernels {
    FfpSsimMoments *blur_moments;
    FfpSsimCompare *compare;
    FfpSsimGradient *add_gradient;
    FfpConvForward *conv2d_forward;
    FfpConvBackward *conv2d_backward;
    FfpPoolForward *maxpool_forward;
    FfpPoolBackward *maxpool_backward;
} FfpLossKernels;

FFP_LOOP_TABLES(FfpLossKernels, loss)

#ifdef FFP_LEVEL
FfpSsimMoments FFP_K(ssim_moments);
FfpSsimCompare FFP_K(ssim_compare);
FfpSsimGradient FFP_K(ssim_gradient);
FfpConvForward FFP_K(conv2d_forward);
FfpConvBackward FFP_K(conv2d_backward);
FfpPoolForward FFP_K(maxpool_forward);
FfpPoolBackward FFP_K(maxpool_backward);
#endif

#endif
