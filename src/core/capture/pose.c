// Poses out of JSON: four rows of four numbers, checked to be rigid and then made so to the last bit. A pose
// that is rigid as far as a float can say stays as it is, so that one that was written comes back the same.
#include <math.h>
#include "core/capture/node.h"

#define RIGID_TOLERANCE 2e-3  // of R^T R - 1: exporters write single precision, people write four digits
#define FLOAT_ROUNDING 2.1e-7 // of R^T R - 1 when R's numbers were rounded to float twice: 4 sqrt(3) 2^-25

static double determinant(const double r[9]) {
    return r[0] * (r[4] * r[8] - r[5] * r[7]) - r[1] * (r[3] * r[8] - r[5] * r[6]) +
           r[2] * (r[3] * r[7] - r[4] * r[6]);
}

// g = R^T R; returns the largest |g - 1|.
static double gram(const double r[9], double g[9]) {
    double worst = 0;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            g[3 * i + j] = r[i] * r[j] + r[3 + i] * r[3 + j] + r[6 + i] * r[6 + j];
            worst = fmax(worst, fabs(g[3 * i + j] - (i == j)));
        }
    }
    return worst;
}

// The nearest rotation, by Newton's iteration for the polar factor, R <- R (3 - R^T R) / 2; three steps take
// an error of the tolerance's size below double precision.
static void orthonormalise(double r[9]) {
    for (int step = 0; step < 3; step++) {
        double g[9], next[9];
        gram(r, g);
        for (int i = 0; i < 3; i++) {
            for (int j = 0; j < 3; j++) {
                double sum = 3 * r[3 * i + j];
                for (int k = 0; k < 3; k++) sum -= r[3 * i + k] * g[3 * k + j];
                next[3 * i + j] = sum / 2;
            }
        }
        for (int i = 0; i < 9; i++) r[i] = next[i];
    }
}

// NULL, or what is wrong with it.
static const char *check_rigid(const double r[9], const real last_row[4]) {
    double g[9];
    for (int i = 0; i < 4; i++)
        if (fabs((double)last_row[i] - (i == 3)) > 1e-6) return "last row is not 0 0 0 1";
    const double error = gram(r, g), det = determinant(r);
    if (fabs(det) < 1e-9) return "matrix is singular";
    if (error > RIGID_TOLERANCE) return "matrix is not rigid: its axes are not orthonormal";
    return det > 0 ? NULL : "matrix mirrors: its axes are left-handed";
}

const char *ffp_pose_settle(real pose[16], bool blender) {
    double r[9], g[9];
    for (int i = 0; i < 9; i++) r[i] = (double)pose[4 * (i / 3) + i % 3];
    const char *wrong = check_rigid(r, pose + 12);
    if (wrong) return wrong;
    if (gram(r, g) > FLOAT_ROUNDING) orthonormalise(r);
    for (int i = 0; i < 9; i++) {
        const double sign = blender && i % 3 > 0 ? -1 : 1; // M diag(1, -1, -1)
        pose[4 * (i / 3) + i % 3] = (real)(sign * r[i]);
    }
    for (int i = 0; i < 4; i++) pose[12 + i] = i == 3;
    return NULL;
}

bool ffp_node_pose(const FfpNode *field, bool blender, real pose[16], FfpError *err) {
    int rows = 0;
    if (!ffp_node_count(field, 4, 4, &rows, err)) return false;
    for (int i = 0; i < rows; i++) {
        FfpNode row;
        if (!ffp_node_item(field, i, &row, err)) return false;
        if (!ffp_node_numbers(&row, 4, -FFP_LENGTH_MAX, FFP_LENGTH_MAX, pose + 4 * i, err)) return false;
    }
    const char *wrong = ffp_pose_settle(pose, blender);
    return !wrong || ffp_node_fail(field, err, "%s", wrong);
}
