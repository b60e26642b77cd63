// Four doubles that work as one: +, - and * by a double, v[c] to look at one. One text for the CPU and the
// GPU.
#ifndef FFP_BASE_FOUR_H
#define FFP_BASE_FOUR_H

#include "core/base/real.h"

#ifdef __CUDACC__

#ifdef __cplusplus
extern "C++" {
typedef struct alignas(32) FfpFour {
    double lane[4];
    __host__ __device__ double operator[](int c) const { return lane[c]; }
} FfpFour;

static __host__ __device__ inline FfpFour operator+(FfpFour a, FfpFour b) {
    for (int c = 0; c < 4; c++) a.lane[c] += b.lane[c];
    return a;
}

static __host__ __device__ inline FfpFour operator-(FfpFour a, FfpFour b) {
    for (int c = 0; c < 4; c++) a.lane[c] -= b.lane[c];
    return a;
}

static __host__ __device__ inline FfpFour operator*(FfpFour a, double b) {
    for (int c = 0; c < 4; c++) a.lane[c] *= b;
    return a;
}
}
#endif

#else

// Read from arrays of doubles, 32 bytes aligned.
typedef double FfpFour __attribute__((vector_size(32), may_alias));

#endif

#endif
