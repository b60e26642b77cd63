// Small vectors, rotations and rigid motions in double precision, for what is calculated once and must be
// exact.
#ifndef FFP_BASE_MOTION_H
#define FFP_BASE_MOTION_H

#include "base/real.h"

typedef struct FfpMotion {
    double r[9], t[3]; // row-major rotation, then translation
} FfpMotion;

static inline FfpMotion ffp_motion(const real pose[16]) {
    FfpMotion m;
    for (int i = 0; i < 9; i++) m.r[i] = (double)pose[4 * (i / 3) + i % 3];
    for (int i = 0; i < 3; i++) m.t[i] = (double)pose[4 * i + 3];
    return m;
}

static inline void ffp_motion_store(const FfpMotion *motion, real pose[16]) { // the last row stays
    for (int i = 0; i < 9; i++) pose[4 * (i / 3) + i % 3] = (real)motion->r[i];
    for (int i = 0; i < 3; i++) pose[4 * i + 3] = (real)motion->t[i];
}

double ffp_dot(const double a[3], const double b[3]);
void ffp_cross(const double a[3], const double b[3], double out[3]);
double ffp_unit(double v[3]); // makes it one, and returns the length it had; 0 stays
// Two unit vectors across a unit vector, which stand across each other.
void ffp_across(const double v[3], double first[3], double second[3]);

// Row-major 3x3 rotations. out may be none of the arguments.
void ffp_turn_product(const double a[9], const double b[9], double out[9]);    // out = a b
void ffp_turn_difference(const double a[9], const double b[9], double out[9]); // out = a^T b
// By |v| radians about v (Rodrigues' formula), and the vector of a rotation below half a turn.
void ffp_turn(const double v[3], double r[9]);
void ffp_turn_vector(const double r[9], double v[3]);

// Minimises 1/2 x'Ax + b'x for symmetric positive A (row-major, its lower half counts and is lost).
void ffp_least_squares(double *a, const double *b, int n, double *x);

#endif
