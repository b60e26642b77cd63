// Matrices, lenses and rigid motions as calibration tools write them.
#ifndef FFP_RIG_MATRIX_H
#define FFP_RIG_MATRIX_H

#include "core/capture/node.h"

#define FFP_MATRIX_MAX 32

typedef struct FfpMatrix {
    int rows, cols;
    double values[FFP_MATRIX_MAX]; // row-major
} FfpMatrix;

// Reads OpenCV's {rows, cols, dt, data}, a list of rows (each a list of numbers or a text "a, b, c"), or a
// flat list of numbers (one column). Errors name the field: sizes that do not fit, more than FFP_MATRIX_MAX
// numbers, numbers that are not finite or beyond 1e9.
bool ffp_node_matrix(const FfpNode *field, FfpMatrix *matrix, FfpError *err);
// The same, of a given shape; a flat list of rows * cols numbers is taken row by row.
bool ffp_node_matrix_of(const FfpNode *field, int rows, int cols, double *values, FfpError *err);

// A rigid motion from a rotation (row-major 3x3) and a translation, checked and made orthonormal as the poses
// of a capture are (ffp_node_pose); `field` is where the rotation stands.
bool ffp_pose_from_rotation(const FfpNode *field, const double rotation[9], const double translation[3],
                            double pose[16], FfpError *err);

// Row-major 4x4 rigid motions. out may be none of the arguments.
void ffp_pose_product(const double a[16], const double b[16], double out[16]); // out = a b
void ffp_pose_inverse(const double a[16], double out[16]);

#endif
