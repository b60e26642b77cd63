// Rotations as quaternions w x y z.
#ifndef FFP_EXPORT_QUATERNION_H
#define FFP_EXPORT_QUATERNION_H

#include "core/base/vec.h"

// out = turn applied to p, in double and by the turn's own length, so that a quarter turn whose parts were
// rounded exchanges coordinates exactly.
static inline void ffp_quaternion_rotate(const real turn[4], const real p[3], real out[3]) {
    const double w = (double)turn[0], v[3] = {(double)turn[1], (double)turn[2], (double)turn[3]};
    const double q[3] = {(double)p[0], (double)p[1], (double)p[2]};
    const double twice = 2 / (w * w + v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    const double across[3] = {v[1] * q[2] - v[2] * q[1], v[2] * q[0] - v[0] * q[2],
                              v[0] * q[1] - v[1] * q[0]};
    const double again[3] = {v[1] * across[2] - v[2] * across[1], v[2] * across[0] - v[0] * across[2],
                             v[0] * across[1] - v[1] * across[0]};
    for (int k = 0; k < 3; k++) out[k] = (real)(q[k] + twice * (w * across[k] + again[k]));
}

// out = first b, then a; not in place.
static inline void ffp_quaternion_product(const real a[4], const real b[4], real out[4]) {
    out[0] = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
    out[1] = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2];
    out[2] = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1];
    out[3] = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0];
}

#endif
