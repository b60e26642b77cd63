// The sRGB transfer functions of IEC 61966-2-1, one text for the CPU and the GPU. image.h has them as plain
// functions.
#ifndef FFP_IMAGE_SRGB_CURVE_H
#define FFP_IMAGE_SRGB_CURVE_H

#include <tgmath.h>
#include "base/real.h"

// Clamps to [0,1] first.
FFP_FORMULA real ffp_srgb_encoded(real linear) {
    if (!(linear > 0)) return 0;
    if (linear >= 1) return 1;
    if (linear <= 0.0031308F) return linear * 12.92F;
    return 1.055F * pow(linear, (real)(1 / 2.4)) - 0.055F;
}

FFP_FORMULA real ffp_srgb_decoded(real encoded) {
    if (encoded <= 0.04045F) return encoded / 12.92F;
    return pow((encoded + 0.055F) / 1.055F, (real)2.4);
}

// Derivative of the encoded value; 0 outside [0,1].
FFP_FORMULA real ffp_srgb_slope(real linear) {
    if (!(linear >= 0) || linear > 1) return 0;
    if (linear <= 0.0031308F) return 12.92F;
    return (real)(1.055 / 2.4) * pow(linear, (real)(1 / 2.4 - 1));
}

#endif
