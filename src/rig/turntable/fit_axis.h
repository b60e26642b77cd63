// The turntable's axis from nothing but the photographs and the angles by which the object turned.
#ifndef FFP_RIG_FIT_AXIS_H
#define FFP_RIG_FIT_AXIS_H

#include "core/capture/capture.h"
#include "rig/turntable/axis.h"

typedef struct FfpAxisReport {
    int stops;
    bool reversed;        // the angles given are left-handed about the axis found
    double outline;       // median distance between silhouettes and the planes that should touch them, pixels
    double surface;       // median distance between the surfaces of neighbouring stops, share of the distance
    int surface_points;   // that were compared
    double error, chance; // root mean square of the colours looked up at the best distance; over all tried
    double tilt, shift; // standard deviations: of the direction, degrees; of the place, share of the distance
} FfpAxisReport;

// Finds the axis that makes silhouettes touch the same planes (outline.h), points have the projector's
// colours at several stops (scan.h), and surfaces turn into each other (cloud.h). The capture has coverage,
// and pictures under black, white and `active`; its poses are not used. `p2c`: projector to camera. `angles`
// [n_views]: degrees. `guess`: near the axis, or NULL. The axis found points up in the picture, or as the
// guess does; its point is the one nearest to the object. Errors (where: `turntable.axis`): fewer than three
// different angles, silhouettes that no axis explains, patterns that tell no distance, an object that looks
// the same about many axes.
bool ffp_fit_axis(FfpAxis *axis, FfpAxisReport *report, const FfpCapture *capture, int active,
                  const double p2c[16], const double *angles, const FfpAxis *guess, FfpError *err);

#endif
