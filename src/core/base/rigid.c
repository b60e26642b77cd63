#include "core/base/rigid.h"
#include <math.h>
#include <stdbool.h>

double ffp_dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

void ffp_cross(const double a[3], const double b[3], double out[3]) {
    const double x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2], z = a[0] * b[1] - a[1] * b[0];
    out[0] = x;
    out[1] = y;
    out[2] = z;
}

double ffp_unit(double v[3]) {
    const double length = sqrt(ffp_dot(v, v));
    for (int i = 0; i < 3 && length > 0; i++) v[i] /= length;
    return length;
}

void ffp_perpendiculars(const double v[3], double first[3], double second[3]) {
    const bool steep = fabs(v[0]) > 0.9;
    const double any[3] = {!steep, steep, 0};
    ffp_cross(v, any, first);
    ffp_unit(first);
    ffp_cross(v, first, second);
}

void ffp_rotation_product(const double a[9], const double b[9], double out[9]) {
    for (int i = 0; i < 9; i++) {
        const double *row = a + 3 * (i / 3), *column = b + i % 3;
        out[i] = row[0] * column[0] + row[1] * column[3] + row[2] * column[6];
    }
}

void ffp_rotation_difference(const double a[9], const double b[9], double out[9]) {
    for (int i = 0; i < 9; i++) {
        const double *left = a + i / 3, *right = b + i % 3;
        out[i] = left[0] * right[0] + left[3] * right[3] + left[6] * right[6];
    }
}

// 1 + sin(a)/a [v] + (1 - cos a)/a^2 [v]^2 with a = |v| and [v] the matrix of the cross product
void ffp_rotation_from_vector(const double v[3], double r[9]) {
    const double square = ffp_dot(v, v), angle = sqrt(square);
    const double s = angle > 1e-9 ? sin(angle) / angle : 1,
                 c = angle > 1e-9 ? (1 - cos(angle)) / square : 0.5;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) r[3 * i + j] = (i == j ? 1 - c * square : 0) + c * v[i] * v[j];
        const int next = (i + 1) % 3, last = (i + 2) % 3;
        r[3 * i + next] -= s * v[last];
        r[3 * i + last] += s * v[next];
    }
}

void ffp_rotation_to_vector(const double r[9], double v[3]) {
    const double half[3] = {(r[7] - r[5]) / 2, (r[2] - r[6]) / 2, (r[3] - r[1]) / 2};
    const double sine = sqrt(ffp_dot(half, half)), angle = atan2(sine, (r[0] + r[4] + r[8] - 1) / 2);
    for (int k = 0; k < 3; k++) v[k] = sine > 1e-12 ? half[k] * angle / sine : half[k];
}

void ffp_rotation_to_quaternion(const double r[9], double wxyz[4]) {
    const double squares[4] = {1 + r[0] + r[4] + r[8], 1 + r[0] - r[4] - r[8], 1 - r[0] + r[4] - r[8],
                               1 - r[0] - r[4] + r[8]}; // of the parts, times 4
    int k = 0;
    for (int i = 1; i < 4; i++) k = squares[i] > squares[k] ? i : k;
    const double s = 2 * sqrt(squares[k]), wx = (r[7] - r[5]) / s, wy = (r[2] - r[6]) / s,
                 wz = (r[3] - r[1]) / s, xy = (r[1] + r[3]) / s, xz = (r[2] + r[6]) / s,
                 yz = (r[5] + r[7]) / s;
    const double all[4][4] = {
        {s / 4, wx, wy, wz}, {wx, s / 4, xy, xz}, {wy, xy, s / 4, yz}, {wz, xz, yz, s / 4}};
    const double sign = all[k][0] < 0 ? -1 : 1, length = sqrt(all[k][0] * all[k][0] + all[k][1] * all[k][1] +
                                                              all[k][2] * all[k][2] + all[k][3] * all[k][3]);
    for (int i = 0; i < 4; i++) wxyz[i] = sign * all[k][i] / length;
}

void ffp_rigid_inverse(const FfpRigid *motion, FfpRigid *out) {
    for (int i = 0; i < 9; i++) out->r[i] = motion->r[3 * (i % 3) + i / 3];
    for (int i = 0; i < 3; i++) out->t[i] = -ffp_dot(out->r + 3 * i, motion->t);
}

void ffp_rigid_product(const FfpRigid *a, const FfpRigid *b, FfpRigid *out) {
    ffp_rotation_product(a->r, b->r, out->r);
    for (int i = 0; i < 3; i++) out->t[i] = ffp_dot(a->r + 3 * i, b->t) + a->t[i];
}
