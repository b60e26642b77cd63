// sRGB values continued outside [0,1].
#ifndef FFP_APPLY_ENCODED_H
#define FFP_APPLY_ENCODED_H

#include <tgmath.h>
#include "core/image/image.h"

// The encoded value and its slope, continued linearly outside [0,1], where the clamped one has no gradient.
static inline real ffp_encode_on(real linear, real *slope) {
    const real held = fmin(fmax(linear, (real)0), (real)1);
    *slope = ffp_srgb_encode_slope(held);
    return ffp_srgb_encode(held) + (linear - held) * *slope;
}

#endif
