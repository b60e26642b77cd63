// The pinhole, one text for the CPU and the GPU.
#ifndef FFP_CAPTURE_PROJECT_H
#define FFP_CAPTURE_PROJECT_H

#include "base/vec.h"
#include "capture/capture.h"

// The text of ffp_project.
FFP_FORMULA real ffp_projected(const FfpCamera *camera, const real point[3], real *x, real *y) {
    real local[3];
    ffp_inverse_transform_point(camera->pose, point, local);
    *x = camera->cx + camera->fx * local[0] / local[2];
    *y = camera->cy + camera->fy * local[1] / local[2];
    return local[2];
}

// Formulas of both say ffp_project. On the CPU that stays a function of its own: which products are fused
// with which sums would depend on what it is inlined into.
#ifdef __CUDACC__
#define ffp_project ffp_projected
#endif

#endif
