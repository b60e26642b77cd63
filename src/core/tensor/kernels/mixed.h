// Matrix products with packed operands, and what linear layers do to C while it is in the cache: inside the
// kernels folder only.
#ifndef FFP_TENSOR_KERNELS_MIXED_H
#define FFP_TENSOR_KERNELS_MIXED_H

#include <stdbool.h>
#include "core/base/level.h"
#include "core/base/real.h"

// C[m,n] = alpha op(A) op(B) + beta C, operands as ffp_gemm's. If `start` is set, C = alpha op(A) op(B) +
// start, where start has rows start_stride apart (0: one row for all of C); it may be C itself.
typedef struct FfpMixed {
    bool transpose_a, transpose_b;
    int m, n, k;
    real alpha;
    const real *a;
    int lda;
    const real *b;
    int ldb;
    real beta;
    real *c;
    int ldc;
    const real *start;
    int start_stride;
} FfpMixed;

void FFP_K(mixed)(const FfpMixed *mixed);

#endif
