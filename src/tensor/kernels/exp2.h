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

// Polynomials for 2^r on |r| <= 1/2 of least greatest relative error (Remez exchange), of a number or a
// vector: of degree 5, 7.5e-8; of degree 3, 7.2e-5.
#define FFP_EXP2_LONG(r)                                                                                     \
    (((((0.00132764720F * (r) + 0.00967554133F) * (r) + 0.0555071327F) * (r) + 0.240221197F) * (r) +         \
      0.693146967F) *                                                                                        \
         (r) +                                                                                               \
     1.00000007F)
#define FFP_EXP2_SHORT(r) (((0.0551716691F * (r) + 0.242611122F) * (r) + 0.693260985F) * (r) + 0.999928074F)

// For x < 127; what lies below -125 counts as -125; NaN stays NaN. Relative
// error with rounding below 2.5e-7.
static inline float ffp_exp2_f32(float x) {
    x = x < -125.0F ? -125.0F : x;
    const float shifted = ffp_shift_power(x), r = x - (shifted - 12582912.0F);
    return ffp_raise(FFP_EXP2_LONG(r), shifted);
}

// The same with degree 3, for results that are rounded to bf16 (half a unit in the last place: 2e-3 to 4e-3):
// relative error below 7.6e-5.
static inline float ffp_exp2_short(float x) {
    x = x < -125.0F ? -125.0F : x;
    const float shifted = ffp_shift_power(x), r = x - (shifted - 12582912.0F);
    return ffp_raise(FFP_EXP2_SHORT(r), shifted);
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
