// Small vectors and rigid 4x4 matrices (row-major), in real. Everything inline.
#ifndef FFP_BASE_VEC_H
#define FFP_BASE_VEC_H

#include <tgmath.h>
#include "core/base/real.h"

FFP_FORMULA real ffp_dot3(const real a[3], const real b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

FFP_FORMULA void ffp_cross3(const real a[3], const real b[3], real out[3]) {
    const real x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2], z = a[0] * b[1] - a[1] * b[0];
    out[0] = x, out[1] = y, out[2] = z;
}

// Normalises in place and returns the former length; a zero vector stays zero.
FFP_FORMULA real ffp_normalise3(real a[3]) {
    const real length = sqrt(ffp_dot3(a, a));
    if (length > 0) a[0] /= length, a[1] /= length, a[2] /= length;
    return length;
}

// out = R p + t for a row-major 4x4 pose (x_to_world).
FFP_FORMULA void ffp_transform_point(const real pose[16], const real p[3], real out[3]) {
    const real x = p[0], y = p[1], z = p[2];
    for (int i = 0; i < 3; i++)
        out[i] = pose[4 * i] * x + pose[4 * i + 1] * y + pose[4 * i + 2] * z + pose[4 * i + 3];
}

FFP_FORMULA void ffp_rotate(const real pose[16], const real p[3], real out[3]) {
    const real x = p[0], y = p[1], z = p[2];
    for (int i = 0; i < 3; i++) out[i] = pose[4 * i] * x + pose[4 * i + 1] * y + pose[4 * i + 2] * z;
}

// out = R^T (p - t): world to camera for a camera-to-world pose.
FFP_FORMULA void ffp_inverse_transform_point(const real pose[16], const real p[3], real out[3]) {
    const real d[3] = {p[0] - pose[3], p[1] - pose[7], p[2] - pose[11]};
    for (int i = 0; i < 3; i++) out[i] = pose[i] * d[0] + pose[4 + i] * d[1] + pose[8 + i] * d[2];
}

FFP_FORMULA void ffp_inverse_rotate(const real pose[16], const real p[3], real out[3]) {
    const real d[3] = {p[0], p[1], p[2]};
    for (int i = 0; i < 3; i++) out[i] = pose[i] * d[0] + pose[4 + i] * d[1] + pose[8 + i] * d[2];
}

// Rotation matrix (row-major) of a quaternion w x y z of length 1.
FFP_FORMULA void ffp_quaternion_matrix(const real q[4], real m[9]) {
    const real w = q[0], x = q[1], y = q[2], z = q[3];
    m[0] = 1 - 2 * (y * y + z * z), m[1] = 2 * (x * y - w * z), m[2] = 2 * (x * z + w * y);
    m[3] = 2 * (x * y + w * z), m[4] = 1 - 2 * (x * x + z * z), m[5] = 2 * (y * z - w * x);
    m[6] = 2 * (x * z - w * y), m[7] = 2 * (y * z + w * x), m[8] = 1 - 2 * (x * x + y * y);
}

#endif
