// Vectors of as many numbers as the CPU level's registers hold, in the vector extension that gcc and clang
// share: operators work lane by lane, and a comparison gives lanes of all or no bits.
#ifndef FFP_RENDER_KERNELS_LANES_H
#define FFP_RENDER_KERNELS_LANES_H

#include <stdbool.h>
#include <stdint.h>
#include <tgmath.h>
#include "core/base/real.h"
#include "core/base/vector.h"
#if defined(__AVX2__)
#include <immintrin.h>
#endif

enum { LANES = FFP_VECTOR_BYTES / sizeof(float) }; // in the double build as many

// No vector ever crosses a call, so how one would be passed does not matter.
#pragma GCC diagnostic ignored "-Wpsabi"
#define ALWAYS_INLINE static inline __attribute__((always_inline))

typedef real Lanes __attribute__((vector_size(LANES * sizeof(real))));
typedef __typeof__((Lanes){0} < (Lanes){0}) Where; // signed integers of the width of a real

typedef uint32_t LaneBits __attribute__((vector_size(LANES * sizeof(uint32_t)))); // of a vector of floats
#define LOG2_E 1.4426950408889634074

ALWAYS_INLINE Lanes lanes_all(real v) {
    return v - (Lanes){0};
}

// v if `so`, otherwise 0.
ALWAYS_INLINE Lanes lanes_keep(Lanes v, Where so) {
    return (Lanes)((Where)v & so);
}

// a where it is so, otherwise b.
ALWAYS_INLINE Lanes lanes_pick(Where so, Lanes a, Lanes b) {
    return (Lanes)(((Where)a & so) | ((Where)b & ~so));
}

// a < b ? a : b, and a > b ? a : b: where one is not a number, b.
ALWAYS_INLINE Lanes lanes_min(Lanes a, Lanes b) {
#if defined(__AVX512F__)
    return (Lanes)_mm512_min_ps((__m512)a, (__m512)b);
#elif defined(__AVX2__)
    return (Lanes)_mm256_min_ps((__m256)a, (__m256)b);
#else
    return lanes_pick(a < b, a, b);
#endif
}

ALWAYS_INLINE Lanes lanes_max(Lanes a, Lanes b) {
#if defined(__AVX512F__)
    return (Lanes)_mm512_max_ps((__m512)a, (__m512)b);
#elif defined(__AVX2__)
    return (Lanes)_mm256_max_ps((__m256)a, (__m256)b);
#else
    return lanes_pick(a > b, a, b);
#endif
}

ALWAYS_INLINE Lanes lanes_sqrt(Lanes v) {
#if defined(__AVX512F__)
    return (Lanes)_mm512_sqrt_ps((__m512)v);
#elif defined(__AVX2__)
    return (Lanes)_mm256_sqrt_ps((__m256)v);
#else
    for (int l = 0; l < LANES; l++) v[l] = sqrt(v[l]);
    return v;
#endif
}

// Bit l is set where lane l is so.
ALWAYS_INLINE unsigned lanes_bits(Where so) {
#if defined(__AVX512F__)
    return _mm512_movepi32_mask((__m512i)so);
#elif defined(__AVX2__)
    return (unsigned)_mm256_movemask_ps((__m256)so);
#else
    unsigned bits = 0;
    for (int l = 0; l < LANES; l++) bits |= (unsigned)(so[l] & 1) << l;
    return bits;
#endif
}

// Bit l is set where lane l is above 0.
ALWAYS_INLINE unsigned lanes_positive(Lanes v) {
#if defined(__AVX512F__)
    return _mm512_cmp_ps_mask((__m512)v, _mm512_setzero_ps(), _CMP_GT_OQ);
#else
    return lanes_bits(v > (Lanes){0});
#endif
}

// 2^t for -126 < t <= 0. In fp32 2^n from the exponent's bits and 2^f from its series, |f| <= 1/2: relative
// error below 2e-7.
ALWAYS_INLINE Lanes lanes_exp2(Lanes t) {
#ifdef FFP_REAL_DOUBLE
    for (int l = 0; l < LANES; l++) t[l] = exp2(t[l]);
    return t;
#else
    const Lanes magic = lanes_all(12582912.0F); // 1.5 * 2^23: the sum's low bits hold n
    const Lanes shifted = t + magic, f = t - (shifted - magic);
    Lanes p = 1.54035304e-4F * f + 0.00133335581F;
    p = p * f + 0.00961812911F;
    p = p * f + 0.0555041087F;
    p = p * f + 0.240226507F;
    p = p * f + 0.693147181F;
    p = p * f + 1.0F;
    return p * (Lanes)(((LaneBits)shifted << 23) + 0x3F800000U); // all but n leaves at the top
#endif
}

#endif
