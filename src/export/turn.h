// Turns as quaternions w x y z.
#ifndef FFP_EXPORT_TURN_H
#define FFP_EXPORT_TURN_H

#include "base/vec.h"

// out = turn applied to p.
static inline void ffp_turn_point(const real turn[4], const real p[3], real out[3]) {
    real across[3], again[3];
    ffp_cross3(turn + 1, p, across);
    for (int k = 0; k < 3; k++) across[k] *= 2;
    ffp_cross3(turn + 1, across, again);
    for (int k = 0; k < 3; k++) out[k] = p[k] + turn[0] * across[k] + again[k];
}

// out = first b, then a; not in place.
static inline void ffp_turn_multiply(const real a[4], const real b[4], real out[4]) {
    out[0] = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
    out[1] = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2];
    out[2] = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1];
    out[3] = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0];
}

#endif
