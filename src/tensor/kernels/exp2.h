// Powers of two that gcc vectorises, for softmax weights and decays. The double build uses libm. Inside the
// kernels folder only.
#ifndef FFP_TENSOR_KERNELS_EXP2_H
#define FFP_TENSOR_KERNELS_EXP2_H

#include <math.h>
#include <stdint.h>
#include "base/real.h"

#define FFP_LOG2_E 1.44269504088896340736
#define FFP_LN_2 0.69314718055994530942

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

// For x < 127; what lies below -125 counts as -125; NaN stays NaN. 2^r by the polynomial of degree 5 whose
// greatest relative error on |r| <= 1/2 is least (Remez exchange): 7.5e-8, with rounding below 2.5e-7.
static inline float ffp_exp2_f32(float x) {
    x = x < -125.0F ? -125.0F : x;
    const float shifted = ffp_shift_power(x), r = x - (shifted - 12582912.0F);
    float p = 0.00132764720F;
    p = p * r + 0.00967554133F;
    p = p * r + 0.0555071327F;
    p = p * r + 0.240221197F;
    p = p * r + 0.693146967F;
    p = p * r + 1.00000007F;
    return ffp_raise(p, shifted);
}

// The same with degree 3, for results that are rounded to bf16 (half a unit in the last place: 2e-3 to 4e-3):
// relative error below 7.6e-5.
static inline float ffp_exp2_short(float x) {
    x = x < -125.0F ? -125.0F : x;
    const float shifted = ffp_shift_power(x), r = x - (shifted - 12582912.0F);
    float p = 0.0551716691F;
    p = p * r + 0.242611122F;
    p = p * r + 0.693260985F;
    p = p * r + 0.999928074F;
    return ffp_raise(p, shifted);
}

static inline real ffp_exp2(real x) {
    return _Generic(x, float : ffp_exp2_f32, double : exp2)(x);
}

// As exact as the packed operand that the result goes into.
static inline real ffp_exp2_packed(real x) {
#ifdef FFP_BF16
    return ffp_exp2_short(x);
#else
    return ffp_exp2(x);
#endif
}

#endif
