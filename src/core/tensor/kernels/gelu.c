// Elementwise: sums, and GELU, exact form: y = x Phi(x) with the normal distribution Phi (Hendrycks & Gimpel
// 2016).
#include "core/tensor/kernels/fastmath.h"
#include "core/tensor/kernels/kernels.h"

void FFP_K(add)(real *y, const real *x, size_t count) {
#pragma omp parallel for simd schedule(static)
    for (size_t i = 0; i < count; i++) y[i] += x[i];
}

void FFP_K(gelu_forward)(real *y, const real *x, size_t count) {
#pragma omp parallel for simd schedule(static)
    for (size_t i = 0; i < count; i++) {
        real density;
        y[i] = x[i] * ffp_normal(x[i], &density);
    }
}

// dy/dx = Phi(x) + x phi(x)
void FFP_K(gelu_backward)(real *dx, const real *dy, const real *x, size_t count) {
#pragma omp parallel for simd schedule(static)
    for (size_t i = 0; i < count; i++) {
        real density;
        const real below = ffp_normal(x[i], &density);
        dx[i] = dy[i] * (below + x[i] * density);
    }
}
