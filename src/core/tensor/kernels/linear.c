// Linear layers.
#include "core/tensor/kernels/columns.h"
#include "core/tensor/kernels/kernels.h"
#include "core/tensor/kernels/mixed.h"

// y = x w^T, with nothing added yet
static FfpMixed forward_product(real *y, const real *x, const real *w, int rows, int in, int out) {
    return (FfpMixed){.transpose_b = true,
                      .m = rows,
                      .n = out,
                      .k = in,
                      .alpha = 1,
                      .a = x,
                      .lda = in,
                      .b = w,
                      .ldb = in,
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
    if (dx) FFP_K(gemm_mixed)(false, false, rows, in, out, 1, dy, out, w, in, 0, dx, in);
    FFP_K(gemm_mixed)(true, false, out, in, rows, 1, dy, out, x, in, 1, dw, in);
    if (dbias) FFP_K(add_column_sums)(dbias, dy, NULL, NULL, NULL, rows, out);
}
