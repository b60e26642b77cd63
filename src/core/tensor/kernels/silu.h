// The sigmoid 1 / (1 + e^-x) and SiLU, x times it, a vector at a time. Inside the kernels folder only.
#ifndef FFP_TENSOR_KERNELS_SILU_H
#define FFP_TENSOR_KERNELS_SILU_H

#include "core/tensor/kernels/exp2.h"
#include "core/tensor/kernels/fastmath.h"
#include "core/tensor/kernels/vector.h"

#ifndef FFP_REAL_DOUBLE
// x within +-limit; NaN stays NaN
static inline FfpVector ffp_clamp_vector(FfpVector x, float limit) {
    const FfpVector zero = {0};
    return ffp_floats_max(zero - limit, ffp_floats_min(zero + limit, x));
}

// 1 + e^-x, with e^-x = 2^n 2^r, n = round(-x log2(e)); ln 2 in two parts, the first exact in 9 bits, so that
// r is exact without a fused multiply-add too. Relative error of what is divided by it below 4e-7 for |x| <=
// 87; beyond, e^-x stays where it exists.
static inline FfpVector ffp_one_and_power(FfpVector x) {
    typedef uint32_t Bits __attribute__((vector_size(FFP_VECTOR_BYTES)));
    const FfpVector held = ffp_clamp_vector(x, 87.0F);
    const FfpVector shifted = 12582912.0F - held * 1.44269504F, n = shifted - 12582912.0F;
    const FfpVector r = (n * 2.12194440e-4F - (held + n * 0.693359375F)) * 1.44269504F;
    return 1.0F + (FfpVector)((Bits)FFP_EXP2_LONG(r) + ((Bits)shifted << 23));
}
#else
static inline FfpVector ffp_one_and_power(FfpVector x) {
    real lanes[FFP_LANES];
    ffp_store(lanes, x);
#pragma omp simd
    for (int i = 0; i < FFP_LANES; i++) lanes[i] = 1 + ffp_exp(-lanes[i]);
    return ffp_load(lanes);
}
#endif

static inline FfpVector ffp_silu_vector(FfpVector x) {
    return x / ffp_one_and_power(x);
}
static inline FfpVector ffp_sigmoid_vector(FfpVector x) {
    return 1 / ffp_one_and_power(x);
}

#endif
