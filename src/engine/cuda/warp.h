// Sums over a warp, the same bits in every lane.
#ifndef FFP_CUDA_WARP_H
#define FFP_CUDA_WARP_H

#include "engine/cuda/launch.h"

static __device__ inline int ffp_lane(void) {
    return (int)(threadIdx.x % FFP_WARP);
}

// All lanes of the warp must come.
static __device__ inline float ffp_warp_sum(float x) {
    for (int other = FFP_WARP / 2; other > 0; other /= 2) x += __shfl_xor_sync(0xffffffffu, x, other);
    return x;
}

static __device__ inline float ffp_warp_max(float x) {
    for (int other = FFP_WARP / 2; other > 0; other /= 2)
        x = fmaxf(x, __shfl_xor_sync(0xffffffffu, x, other));
    return x;
}

static __device__ inline float ffp_logistic(float x) {
    return 1 / (1 + expf(-x));
}

#endif
