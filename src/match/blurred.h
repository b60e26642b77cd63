// Squared difference to a blurred pattern: the innermost loop of matching.
#ifndef FFP_MATCH_BLURRED_H
#define FFP_MATCH_BLURRED_H

#include "match/observe.h"

// What a pixel saw, padded to four channels as the cells are.
typedef struct FfpSeen {
    real ratio[4], weight[4];
} FfpSeen;

static inline FfpSeen ffp_seen(const FfpObservation *seen, size_t pixel) {
    const real *r = seen->ratio + 3 * pixel, *w = seen->weight + 3 * pixel;
    return (FfpSeen){{r[0], r[1], r[2], 0}, {w[0], w[1], w[2], 0}};
}

// Sum over channels of weight (ratio - pattern)^2 at (u, v), bilinear; `outside` off the pattern.
static inline real ffp_blurred_cost(const FfpBlurred *blurred, real u, real v, const FfpSeen *seen,
                                    real outside) {
    if (!(u >= 0 && v >= 0 && u <= blurred->width && v <= blurred->height)) return outside;
    const real x = u * blurred->scale + 0.5F, y = v * blurred->scale + 0.5F; // the border shifts by one cell
    const int i = (int)x, j = (int)y;
    const real a = x - (real)i, b = y - (real)j, aa = 1 - a, bb = 1 - b;
    const real *p = blurred->cells + 4 * ((size_t)j * (size_t)blurred->stride + (size_t)i);
    const real *q = p + 4 * (size_t)blurred->stride;
    real term[4];
    for (int c = 0; c < 4; c++) {
        const real shown = (p[c] * aa + p[4 + c] * a) * bb + (q[c] * aa + q[4 + c] * a) * b;
        const real off = seen->ratio[c] - shown;
        term[c] = seen->weight[c] * off * off;
    }
    return (term[0] + term[1]) + (term[2] + term[3]);
}

#endif
