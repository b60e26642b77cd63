// Linear layers.
#include "core/tensor/kernels/columns.h"
#include "core/tensor/kernels/kernels.h"
#include "core/tensor/kernels/mixed.h"

// y = x w^T, with nothing added yet
static FfpMixed forward_product(real *y, const real *x, const real *w, int rows, int in, int out) {
    return (FfpMixed){.alpha = 1,
                      .a = ffp_factor(x, rows, in, in),
                      .b = ffp_transposed(ffp_factor(w, out, in, in)),
                      .c = y,
                      .ldc = out};
}

void FFP_K(linear_forward)(real *y, const real *x, const real *w, const real *bias, int rows, int in,
                           int out) {
    FfpMixed product = forward_product(y, x, w, rows, in, out);
    product.start = bias;
    FFP_K(mixed)(&product);
}

void FFP_K(linear_residual_forward)(real *y, const real *residual, const real *x, const real *w, int rows,
                                    int in, int out) {
    FfpMixed product = forward_product(y, x, w, rows, in, out);
    product.start = residual;
    product.start_stride = out;
    FFP_K(mixed)(&product);
}

// dx = dy w, dw += dy^T x, dbias += column sums of dy
void FFP_K(linear_backward)(real *dx, real *dw, real *dbias, const real *dy, const real *x, const real *w,
                            int rows, int in, int out) {
    const FfpFactor from = ffp_factor(dy, rows, out, out);
    if (dx) FFP_K(gemm_mixed)(1, from, ffp_factor(w, out, in, in), 0, dx, in);
    FFP_K(gemm_mixed)(1, ffp_transposed(from), ffp_factor(x, rows, in, in), 1, dw, in);
    if (dbias) FFP_K(add_column_sums)(dbias, dy, NULL, NULL, NULL, rows, out);
}
