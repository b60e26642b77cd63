// Surfaces that the projector's pattern gives at each stop by itself. About the right axis they turn into
// each other.
#ifndef FFP_RIG_CLOUD_H
#define FFP_RIG_CLOUD_H

#include "rig/turntable/outline.h"

typedef struct FfpCloudPoint {
    int stop, next;   // the stop that it was measured at, and one that may see it too
    double at[3];     // camera coordinates at the first
    double normal[3]; // unit, towards the camera
} FfpCloudPoint;

typedef struct FfpClouds {
    const FfpCamera *camera; // the same at all stops
    const double *angles;    // radians
    double far;              // a distance beyond which two surfaces are different ones
    double (**planes)[3];    // [n][h * w]: n with n . X = 1 for the surface there; 0 0 0: none
    int n, count;
    FfpCloudPoint *points; // [count]
} FfpClouds;

// Matches `active` at every stop within the object's sphere as it is about the axis, and fits planes to the
// depth of 5 x 5 pixels. The capture as for ffp_scan_distance.
FfpClouds ffp_clouds_new(const FfpCapture *capture, int active, const FfpOutlines *outlines,
                         const FfpAxis *axis);
void ffp_clouds_free(FfpClouds *clouds);

// [count] How far each point, turned to its other stop, lies before that stop's surface, in the calibration's
// unit. None where there is no such surface, or one that looks elsewhere.
void ffp_cloud_residuals(const void *context, const FfpAxis *axis, double *residuals);

// A capture without ownership: the views of `capture` placed about the axis, all of them as if only the
// object had turned; its sphere; then normalised. Release with ffp_placed_free. *radius: what lengths were
// divided by.
FfpCapture ffp_placed_new(const FfpCapture *capture, const FfpOutlines *outlines, const FfpAxis *axis,
                          double *radius);
void ffp_placed_free(FfpCapture *placed);

#endif
