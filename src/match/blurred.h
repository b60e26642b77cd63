// Sampling of a blurred pattern in the inner loops.
#ifndef FFP_MATCH_BLURRED_H
#define FFP_MATCH_BLURRED_H

#include "match/observe.h"

// Bilinear, edge clamped; (u, v) in pattern pixels, inside the pattern.
static inline void ffp_blurred_sample(const FfpBlurred *blurred, real u, real v, real out[3]) {
    const int w = blurred->image.width, h = blurred->image.height;
    const real x = u * blurred->scale - 0.5F, y = v * blurred->scale - 0.5F;
    const real xc = x < 0               ? 0
                    : x > (real)(w - 1) ? (real)(w - 1)
                                        : x,
               yc = y < 0               ? 0
                    : y > (real)(h - 1) ? (real)(h - 1)
                                        : y;
    const int i = xc >= (real)(w - 1) ? w - 2 : (int)xc, j = yc >= (real)(h - 1) ? h - 2 : (int)yc;
    const real a = xc - (real)i, b = yc - (real)j;
    const real *p = blurred->image.data + 3 * ((size_t)j * (size_t)w + (size_t)i), *q = p + 3 * (size_t)w;
    for (int c = 0; c < 3; c++)
        out[c] = (p[c] * (1 - a) + p[3 + c] * a) * (1 - b) + (q[c] * (1 - a) + q[3 + c] * a) * b;
}

#endif
