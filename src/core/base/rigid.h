// Small vectors, rotations and rigid transforms in double precision, for calculations that are done once and
// must be exact.
#ifndef FFP_BASE_RIGID_H
#define FFP_BASE_RIGID_H

#include "core/base/real.h"

typedef struct FfpRigid {
    double r[9], t[3]; // row-major rotation, then translation
} FfpRigid;

static inline FfpRigid ffp_rigid_from_pose(const real pose[16]) {
    FfpRigid m;
    for (int i = 0; i < 9; i++) m.r[i] = (double)pose[4 * (i / 3) + i % 3];
    for (int i = 0; i < 3; i++) m.t[i] = (double)pose[4 * i + 3];
    return m;
}

static inline void ffp_rigid_store(const FfpRigid *motion, real pose[16]) { // the last row stays
    for (int i = 0; i < 9; i++) pose[4 * (i / 3) + i % 3] = (real)motion->r[i];
    for (int i = 0; i < 3; i++) pose[4 * i + 3] = (real)motion->t[i];
}

double ffp_dot(const double a[3], const double b[3]);
void ffp_cross(const double a[3], const double b[3], double out[3]);
double ffp_unit(double v[3]); // makes it one, and returns the length it had; 0 stays
// Two unit vectors perpendicular to a unit vector and to each other.
void ffp_perpendiculars(const double v[3], double first[3], double second[3]);

// Row-major 3x3 rotations. out may be none of the arguments.
void ffp_rotation_product(const double a[9], const double b[9], double out[9]);    // out = a b
void ffp_rotation_difference(const double a[9], const double b[9], double out[9]); // out = a^T b
// By |v| radians about v (Rodrigues' formula), and the vector of a rotation below half a turn.
void ffp_rotation_from_vector(const double v[3], double r[9]);
void ffp_rotation_to_vector(const double r[9], double v[3]);
// The unit quaternion w x y z of a rotation, w >= 0, by its largest part (Shepperd 1978).
void ffp_rotation_to_quaternion(const double r[9], double wxyz[4]);

// x -> r^T (x - t), and x -> a (b x). out may be none of the arguments.
void ffp_rigid_inverse(const FfpRigid *motion, FfpRigid *out);
void ffp_rigid_product(const FfpRigid *a, const FfpRigid *b, FfpRigid *out);

#endif
