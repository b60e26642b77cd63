// The sRGB transfer functions (IEC 61966-2-1), for one number.
#ifndef FFP_IMAGE_SRGB_FORMULA_H
#define FFP_IMAGE_SRGB_FORMULA_H

// Not tgmath.h, whose macros would change what sqrt means to those who include image.h.
#include <math.h>
#include <stdbool.h>
#include "core/base/exp2.h"
#include "core/base/real.h"

FFP_FORMULA real ffp_srgb_power(real x, real exponent) {
#ifdef FFP_REAL_DOUBLE
    return pow(x, exponent);
#else
    return powf(x, exponent);
#endif
}

// Clamps to [0,1] first.
FFP_FORMULA real ffp_srgb_encode(real linear) {
    if (!(linear > 0)) return 0;
    if (linear >= 1) return 1;
    if (linear <= 0.0031308F) return linear * 12.92F;
    return 1.055F * ffp_srgb_power(linear, (real)(1 / 2.4)) - 0.055F;
}

FFP_FORMULA real ffp_srgb_decode(real encoded) {
    if (encoded <= 0.04045F) return encoded / 12.92F;
    return ffp_srgb_power((encoded + 0.055F) / 1.055F, (real)2.4);
}

// ffp_srgb_encode, and its derivative (0 outside [0,1]) from the same power: without a branch or libm, so
// that loops over it vectorise; to a few units in the last place.
FFP_FORMULA real ffp_srgb_encode_with_slope(real linear, real *slope) {
    const bool curved = linear > 0.0031308F, bright = linear >= 1;
    const real positive = linear > 0 ? linear : 0;
    const real held = curved ? (bright ? 1 : linear) : 0.0031308F; // the power's range
    const real power = ffp_exp2((real)(1 / 2.4) * ffp_log2(held));
    const real curve = bright ? 1 : 1.055F * power - 0.055F;
    const real bent = linear > 1 ? 0 : (real)(1.055 / 2.4) * power / held;
    *slope = curved ? bent : linear >= 0 ? 12.92F : 0;
    return curved ? curve : 12.92F * positive;
}

// Derivative of ffp_srgb_encode; 0 outside [0,1].
FFP_FORMULA real ffp_srgb_encode_slope(real linear) {
    if (!(linear >= 0) || linear > 1) return 0;
    if (linear <= 0.0031308F) return 12.92F;
    return (real)(1.055 / 2.4) * ffp_srgb_power(linear, (real)(1 / 2.4 - 1));
}

#endif
