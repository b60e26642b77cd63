// The constraints that the pixels of a view place on its devices.
#ifndef FFP_ALIGN_TIE_POINTS_H
#define FFP_ALIGN_TIE_POINTS_H

#include "core/base/rigid.h"
#include "engine/match/match.h"

// The numbers of a view that move a point: camera's turn and shift, projector's turn and shift, logarithms of
// the two focal lengths.
enum { FFP_TIE_POINT_NUMBERS = 14 };

typedef struct FfpDeviceAt { // a device in double
    FfpRigid at;
    double fx, fy, cx, cy;
} FfpDeviceAt;
FfpDeviceAt ffp_device_at(const FfpCamera *camera);

typedef struct FfpTiePoint {
    double x, y, u, v;    // pixel of the camera, position in the projector that it sees
    double weight;        // of `off`: 1 / variance, projector pixels
    double trust;         // of the point
    double footprint;     // world width of a camera pixel there
    double normal[3];     // unit, world
    double point[3], off; // where the rays meet, and by how much they miss in the projector, across them
    double point_by[FFP_TIE_POINT_NUMBERS][3], off_by[FFP_TIE_POINT_NUMBERS]; // their derivatives
} FfpTiePoint;

typedef struct FfpTiePoints {
    int view, width, height;
    int64_t count;
    FfpTiePoint *all;
    int *index; // [h,w] of a pixel's tie point, -1: none
} FfpTiePoints;

// The pixels of a view whose depth is trusted. The position in the projector is that of the correspondences
// if they are known, or otherwise the matched one, moved to where the pattern around it fits best (Lucas and
// Kanade 1981), because matching does not search across the ray.
FfpTiePoints ffp_tie_points_new(const FfpCapture *capture, const FfpInitialisation *start, int view,
                                int active);
void ffp_tie_points_free(FfpTiePoints *tie_points);

#endif
