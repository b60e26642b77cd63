// Powers of two and of e, and logarithms, that gcc vectorises: libm's are a call per element. The double
// build uses libm, the GPU its own.
#ifndef FFP_BASE_EXP2_H
#define FFP_BASE_EXP2_H

#include <math.h>
#include <stdint.h>
#include "core/base/real.h"

#ifdef __CUDACC__

#define ffp_exp2 exp2f
#define ffp_exp expf
#define ffp_log2 log2f

#else

// 2^x = 2^n 2^r, n the integer nearest to x. shift_power gives n (behind the sum with 1.5 * 2^23 the low
// mantissa bits hold it), raise multiplies by 2^n in the exponent's bits.
static inline float ffp_shift_power(float x) {
    return x + 12582912.0F;
}
static inline float ffp_raise(float p, float shifted) {
    union {
        float number;
        uint32_t bits;
    } power = {.number = p}, n = {.number = shifted};
    power.bits += n.bits << 23;
    return power.number;
}

// The minimax polynomial (least maximum relative error) for 2^r on |r| <= 1/2 (Remez exchange), of a number
// or a vector: of degree 5, 7.5e-8.
#define FFP_EXP2_LONG(r)                                                                                     \
    (((((0.00132764720F * (r) + 0.00967554133F) * (r) + 0.0555071327F) * (r) + 0.240221197F) * (r) +         \
      0.693146967F) *                                                                                        \
         (r) +                                                                                               \
     1.00000007F)

// For x < 127; values below -125 count as -125; NaN stays NaN. Relative
// error with rounding below 2.5e-7.
static inline float ffp_exp2_f32(float x) {
    x = x < -125.0F ? -125.0F : x;
    const float shifted = ffp_shift_power(x), r = x - (shifted - 12582912.0F);
    return ffp_raise(FFP_EXP2_LONG(r), shifted);
}

static inline real ffp_exp2(real x) {
#ifdef FFP_REAL_DOUBLE
    return exp2(x);
#else
    return ffp_exp2_f32(x);
#endif
}

// For normal numbers above 0: the exponent, and of the mantissa m in [sqrt(1/2), sqrt(2)] the series of
// log2 m = 2 / ln 2 artanh((m - 1) / (m + 1)) up to the ninth power (remainder below 1e-9).
static inline float ffp_log2_f32(float x) {
    union {
        float number;
        uint32_t bits;
    } mantissa = {.number = x};
    const int32_t exponent = (int32_t)(mantissa.bits - 0x3F3504F3U) >> 23;
    mantissa.bits -= (uint32_t)exponent << 23;
    const float s = (mantissa.number - 1) / (mantissa.number + 1), q = s * s;
    const float series =
        (((0.320598898F * q + 0.412198583F) * q + 0.577078016F) * q + 0.961796694F) * q + 2.88539008F;
    return (float)exponent + s * series;
}

static inline real ffp_log2(real x) {
#ifdef FFP_REAL_DOUBLE
    return log2(x);
#else
    return ffp_log2_f32(x);
#endif
}

// e^x = 2^n e^r with |r| <= ln 2 / 2 and e^r by its Taylor sum up to r^7 (remainder below 6e-9). Relative
// error below 2e-7 on [-87, 88]; saturates outside (1.6e-38, 1.7e38); NaN stays NaN.
static inline float ffp_exp_f32(float x) {
    x = x < -87.0F ? -87.0F : x;
    x = x > 88.0F ? 88.0F : x;
    const float magic =
        12582912.0F; // 1.5 * 2^23: behind the sum the low mantissa bits hold n = round(x / ln 2)
    const float shifted = x * 1.44269504F + magic, n = shifted - magic;
    const float r =
        (x - n * 0.693359375F) + n * 2.12194440e-4F; // ln 2 in two parts, the first exact in 9 bits
    float p = 1.0F / 5040.0F;
    p = p * r + 1.0F / 720.0F;
    p = p * r + 1.0F / 120.0F;
    p = p * r + 1.0F / 24.0F;
    p = p * r + 1.0F / 6.0F;
    p = p * r + 0.5F;
    p = p * r + 1.0F;
    p = p * r + 1.0F;
    union {
        float number;
        uint32_t bits;
    } scale = {.number = shifted};
    scale.bits = (scale.bits << 23) + 0x3F800000U; // 2^n: everything but n leaves at the top
    return p * scale.number;
}

static inline real ffp_exp(real x) {
#ifdef FFP_REAL_DOUBLE
    return exp(x);
#else
    return ffp_exp_f32(x);
#endif
}

#endif

#endif
