// Linear layers.
#include "tensor/kernels/kernels.h"

#include <string.h>
#include "tensor/kernels/columns.h"

void FFP_K(linear_forward)(real *y, const real *x, const real *w, const real *bias, int rows, int in,
                           int out) {
    if (bias) {
#pragma omp parallel for schedule(static)
        for (int t = 0; t < rows; t++) memcpy(y + (size_t)t * out, bias, sizeof(real) * (size_t)out);
    }
    ffp_gemm(false, true, rows, out, in, 1, x, in, w, in, bias ? 1 : 0, y, out);
}

// dx = dy w, dw += dy^T x, dbias += column sums of dy
void FFP_K(linear_backward)(real *dx, real *dw, real *dbias, const real *dy, const real *x, const real *w,
                            int rows, int in, int out) {
    if (dx) ffp_gemm(false, false, rows, in, out, 1, dy, out, w, in, 0, dx, in);
    ffp_gemm(true, false, out, in, rows, 1, dy, out, x, in, 1, dw, in);
    if (dbias) FFP_K(add_column_sums)(dbias, dy, NULL, NULL, NULL, rows, out);
}
