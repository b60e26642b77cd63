// The pinhole, one text for the CPU and the GPU.
#ifndef FFP_CAPTURE_PROJECT_H
#define FFP_CAPTURE_PROJECT_H

#include "core/base/vec.h"
#include "core/capture/capture.h"

// The pixel position at which the camera sees a point of its own frame.
FFP_FORMULA void ffp_in_picture(const FfpCamera *camera, const real local[3], real *x, real *y) {
    *x = camera->cx + camera->fx * local[0] / local[2];
    *y = camera->cy + camera->fy * local[1] / local[2];
}

// The body of ffp_project, which on the CPU is a separate function, not inlined: inlining would change which
// products are fused with which sums.
FFP_FORMULA real ffp_projected(const FfpCamera *camera, const real point[3], real *x, real *y) {
    real local[3];
    ffp_inverse_transform_point(camera->pose, point, local);
    ffp_in_picture(camera, local, x, y);
    return local[2];
}

#endif
