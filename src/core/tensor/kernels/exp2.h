// Powers of two for softmax weights and decays (core/base/exp2.h), and cheaper ones. Inside the kernels
// folder only.
#ifndef FFP_TENSOR_KERNELS_EXP2_H
#define FFP_TENSOR_KERNELS_EXP2_H

#include "core/base/exp2.h"

#define FFP_LOG2_E 1.44269504088896340736
#define FFP_LN_2 0.69314718055994530942

// As FFP_EXP2_LONG of degree 3: 7.2e-5.
#define FFP_EXP2_SHORT(r) (((0.0551716691F * (r) + 0.242611122F) * (r) + 0.693260985F) * (r) + 0.999928074F)

// ffp_exp2_f32 with degree 3, for results that are rounded to bf16 (half a unit in the last place: 2e-3 to
// 4e-3): relative error below 7.6e-5.
static inline float ffp_exp2_short(float x) {
    x = x < -125.0F ? -125.0F : x;
    const float shifted = ffp_shift_power(x), r = x - (shifted - 12582912.0F);
    return ffp_raise(FFP_EXP2_SHORT(r), shifted);
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
