// Splats under a linear transform: rotation, scales along axes, shear, reflection.
#ifndef FFP_GAUSSIANS_AFFINE_H
#define FFP_GAUSSIANS_AFFINE_H

#include "core/gaussians/row.h"

typedef struct FfpAffine {
    double a[9], t[3]; // x -> a x + t; a by rows
} FfpAffine;

FfpAffine ffp_affine_product(const FfpAffine *after, const FfpAffine *before);
void ffp_affine_rotation(const double q[4], double r[9]); // w x y z of any length but 0 (then NaN)
// Moves the splat of a row: its centre, and scales and rotation so that its covariance S becomes a S a^T. A
// logarithm of -inf stays one. A rotation or scales that are not finite stay.
void ffp_affine_move(const FfpAffine *affine, float row[FFP_ROW_NUMBERS]);

#endif
