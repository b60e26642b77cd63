// Matrix products with packed operands, and what linear layers do to C while it is in the cache: inside the
// kernels folder only.
#ifndef FFP_TENSOR_KERNELS_MIXED_H
#define FFP_TENSOR_KERNELS_MIXED_H

#include "core/base/level.h"
#include "core/tensor/tensor.h"

// C = alpha A B + beta C, as ffp_gemm. If `start` is set, C = alpha A B + start, where start has rows
// start_stride apart (0: one row for all of C); it may be C itself.
typedef struct FfpMixed {
    real alpha;
    FfpFactor a, b;
    real beta;
    real *c;
    int ldc;
    const real *start;
    int start_stride;
} FfpMixed;

void FFP_K(mixed)(const FfpMixed *mixed);

#endif
