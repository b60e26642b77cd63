// A camera pixel's ray as another device sees it: both image coordinates are ratios of functions linear in
// camera depth.
#ifndef FFP_MATCH_LINE_H
#define FFP_MATCH_LINE_H

#include "core/base/vec.h"
#include "core/capture/capture.h"

// u = (u[0] + u[1] z) / (w[0] + w[1] z), v likewise; w[0] + w[1] z is the depth in front of the device.
typedef struct FfpLine {
    real u[2], v[2], w[2];
} FfpLine;

// The ray through pixel position (x, y) of `camera`, at camera depth z, seen from `device`.
FFP_FORMULA FfpLine ffp_line(const FfpCamera *camera, real x, real y, const FfpCamera *device) {
    const real local[3] = {(x - camera->cx) / camera->fx, (y - camera->cy) / camera->fy, 1};
    const real eye[3] = {camera->pose[3], camera->pose[7], camera->pose[11]};
    real direction[3], a[3], b[3];
    ffp_rotate(camera->pose, local, direction);
    ffp_inverse_transform_point(device->pose, eye, a);
    ffp_inverse_rotate(device->pose, direction, b);
    return (FfpLine){{device->fx * a[0] + device->cx * a[2], device->fx * b[0] + device->cx * b[2]},
                     {device->fy * a[1] + device->cy * a[2], device->fy * b[1] + device->cy * b[2]},
                     {a[2], b[2]}};
}

// Position in the device's image; returns the depth in front of it, and leaves u, v alone where that is not
// positive.
static inline real ffp_line_at(const FfpLine *line, real z, real *u, real *v) {
    const real w = line->w[0] + line->w[1] * z;
    if (w > 1e-6F) {
        *u = (line->u[0] + line->u[1] * z) / w;
        *v = (line->v[0] + line->v[1] * z) / w;
    }
    return w;
}

// Hypotheses, or pixels of a row, that the inner loops take at a time; of a GPU's threads each takes one.
#ifdef __cplusplus
#define FFP_MATCH_LANES 1
#else
#define FFP_MATCH_LANES 16
#endif

// Positions at the depths first + (from + n) step, n < FFP_MATCH_LANES; -1 where they are behind either
// device. With u, v, w turned round in the line, and inverse depths, it is the same line.
FFP_FORMULA void ffp_line_positions(const FfpLine *line, real first, real step, int from,
                                    real u[FFP_MATCH_LANES], real v[FFP_MATCH_LANES]) {
    for (int n = 0; n < FFP_MATCH_LANES; n++) {
        const real z = first + (real)(from + n) * step, w = line->w[0] + line->w[1] * z;
        const bool front = (z > 0) & (w > 1e-6F);
        const real inverse = 1 / w;
        u[n] = front ? (line->u[0] + line->u[1] * z) * inverse : -1;
        v[n] = front ? (line->v[0] + line->v[1] * z) * inverse : -1;
    }
}

// World point of pixel position (x, y) at camera depth z.
static inline void ffp_point_at(const FfpCamera *camera, real x, real y, real z, real point[3]) {
    const real local[3] = {(x - camera->cx) / camera->fx * z, (y - camera->cy) / camera->fy * z, z};
    ffp_transform_point(camera->pose, local, point);
}

#endif
