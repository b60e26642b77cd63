// Numbers as bf16 (the upper half of an fp32 number), rounded to nearest, ties to even.
#ifndef FFP_CUDA_BF16_H
#define FFP_CUDA_BF16_H

#include "engine/cuda/launch.h"

// Two of them, `low` at the lower address.
static __device__ inline uint32_t ffp_bf16_pair(float low, float high) {
#ifdef __CUDACC__
    uint32_t pair;
    asm("cvt.rn.bf16x2.f32 %0, %1, %2;" : "=r"(pair) : "f"(high), "f"(low));
    return pair;
#else
    const float numbers[2] = {low, high};
    uint32_t rounded[2];
    for (int i = 0; i < 2; i++) {
        const uint32_t bits = __float_as_uint(numbers[i]);
        const bool nan = (bits & 0x7fffffffU) > 0x7f800000U;
        rounded[i] = nan ? 0x7fffU : (bits + 0x7fffU + (bits >> 16 & 1U)) >> 16;
    }
    return rounded[1] << 16 | rounded[0];
#endif
}

static __device__ inline uint16_t ffp_bf16(float x) {
    return (uint16_t)ffp_bf16_pair(x, 0);
}

#endif
