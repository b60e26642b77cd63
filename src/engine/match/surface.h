// Local planes of a depth map. A plane's inverse depth is linear in pixel coordinates: q = q0 + qx dx + qy
// dy.
#ifndef FFP_MATCH_SURFACE_H
#define FFP_MATCH_SURFACE_H

#include "core/base/real.h"
#include "core/capture/capture.h"
#include "engine/match/line.h"

typedef struct FfpPlane {
    real q0, qx, qy; // inverse depth at the pixel, and its change a pixel right and down
} FfpPlane;

// A depth map with its weights, and a border wide enough to fit planes at every pixel.
typedef struct FfpSheet {
    int width, height, stride, reach;
    real focal;                     // fx of the camera
    real *depth, *inverse, *weight; // [height + 2 reach, stride]; all 0 where nothing is known
    real *nearness, *jump; // [2 reach + 1, 2 reach + 1] of a neighbour by its distance: its weight, and the
                           // step in footprints beyond which it lies across a depth jump
} FfpSheet;

// depth [h,w]: camera z, 0 for none. weight [h,w]: 0 for pixels that must not influence their neighbours.
FfpSheet ffp_sheet_new(const real *depth, const real *weight, const FfpCamera *camera, int reach);
void ffp_sheet_neighbours(FfpSheet *sheet); // makes nearness and jump alone
void ffp_sheet_free(FfpSheet *sheet);

// Planes at the FFP_MATCH_LANES pixels from (x, y) rightwards, as far as the picture goes: least squares over
// the (2 reach + 1)^2 pixels around each that have depth > 0 and weight > 0, without those across a depth
// jump, in further rounds without outliers. q0 is 0 where there is no depth at the pixel; with too few
// neighbours the plane faces the camera.
void ffp_fit_planes(FfpPlane planes[FFP_MATCH_LANES], const FfpSheet *sheet, int x, int y);

// Unit world normal of the plane at pixel position (x, y), facing the camera.
void ffp_plane_normal(const FfpPlane *plane, const FfpCamera *camera, real x, real y, real normal[3]);

#endif
