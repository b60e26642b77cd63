// Local planes of a depth map. A plane's inverse depth is linear in pixel coordinates: q = q0 + qx dx + qy
// dy.
#ifndef FFP_MATCH_SURFACE_H
#define FFP_MATCH_SURFACE_H

#include <stdbool.h>
#include "base/real.h"
#include "capture/capture.h"

typedef struct FfpPlane {
    real q0, qx, qy; // inverse depth at the pixel, and its change a pixel right and down
} FfpPlane;

// Least squares over the (2 reach + 1)^2 pixels around (x, y) that have depth > 0 and weight > 0, without
// those across a depth jump, in a second round without outliers. Depth: camera z. Returns false when there is
// no depth at the pixel; with too few neighbours the plane faces the camera.
bool ffp_fit_plane(FfpPlane *plane, const real *depth, const real *weight, const FfpCamera *camera, int x,
                   int y, int reach);

// Unit world normal of the plane at pixel position (x, y), facing the camera.
void ffp_plane_normal(const FfpPlane *plane, const FfpCamera *camera, real x, real y, real normal[3]);

#endif
