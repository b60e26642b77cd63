// Without OpenBLAS: products of the level that every page runs, in fp32 as OpenBLAS's are.
#include "core/tensor/kernels/kernels.h"

__typeof__(ffp_gemm) ffp_simd128_gemm_mixed;

void ffp_blas_gemm(real alpha, FfpFactor a, FfpFactor b, real beta, real *c, int ldc) {
    ffp_simd128_gemm_mixed(alpha, a, b, beta, c, ldc);
}
