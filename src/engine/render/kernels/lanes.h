// Vectors of as many numbers as the CPU level's registers hold, in the vector extension that gcc and clang
// share: operators work lane by lane, and a comparison gives lanes of all or no bits.
#ifndef FFP_RENDER_KERNELS_LANES_H
#define FFP_RENDER_KERNELS_LANES_H

#include <stdbool.h>
#include <stdint.h>
#include <tgmath.h>
#include "core/base/real.h"
#include "core/base/vector.h"

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

// core/base/vector.h, in both builds.
#ifdef FFP_REAL_DOUBLE
ALWAYS_INLINE Lanes lanes_min(Lanes a, Lanes b) {
    return lanes_pick(a < b, a, b);
}
ALWAYS_INLINE Lanes lanes_max(Lanes a, Lanes b) {
    return lanes_pick(a > b, a, b);
}
ALWAYS_INLINE Lanes lanes_sqrt(Lanes v) {
    for (int l = 0; l < LANES; l++) v[l] = sqrt(v[l]);
    return v;
}
ALWAYS_INLINE unsigned lanes_bits(Where so) {
    unsigned bits = 0;
    for (int l = 0; l < LANES; l++) bits |= (unsigned)(so[l] & 1) << l;
    return bits;
}
#else
#define lanes_min ffp_floats_min
#define lanes_max ffp_floats_max
#define lanes_sqrt ffp_floats_sqrt
#define lanes_bits ffp_floats_bits
#endif

// Bit l is set where lane l is above 0.
ALWAYS_INLINE unsigned lanes_positive(Lanes v) {
    return lanes_bits(v > (Lanes){0});
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
