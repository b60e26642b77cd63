// A device's place and lens from known points of space and the pixels at which it has them (resection).
#ifndef FFP_NUMERICS_RESECTION_H
#define FFP_NUMERICS_RESECTION_H

#include <stdbool.h>
#include "core/base/error.h"
#include "core/base/rigid.h"

#define FFP_USUAL_FOCAL 1.6 // of a projector: of its panel's width

// Numbers of a device, in the order of their deviations: turned about its own axes (radians) and moved along
// them (the points' unit), the logarithm of its focal length, its principal point (shares of the width), and
// how much longer its focal length is along y.
enum {
    FFP_RESECTED_TURN,
    FFP_RESECTED_PLACE = 3,
    FFP_RESECTED_FOCAL = 6,
    FFP_RESECTED_X,
    FFP_RESECTED_Y,
    FFP_RESECTED_ASPECT,
    FFP_RESECTED
};

typedef struct FfpResection {
    double fx, fy, x, y;            // pixels
    FfpRigid pose;                  // the points' frame to the device's
    double deviation[FFP_RESECTED]; // standard deviation of each number
    double rms, median;             // distance of the points used from their pixels; of all; pixels
    int used;                       // points within three deviations of the noise
} FfpResection;

// From n points [n,3] and their pixels [n,2] on a panel of width x height; half of them may be wrong. Begins
// with the linear solution of eight points for which the median distance is least (Rousseeuw 1984), and goes
// on by robust least squares (Geman and McClure). The numbers of the lens are as far from those of usual
// projectors as the points make likely; what these do not determine stays usual, and its deviation says so.
// Neighbouring points share their errors, so deviations are those of the results without one part of the
// panel each (a grouped jackknife: Tukey 1958), or those that one fit tells, if these are larger. Errors that
// all points have in common, as of a lens that distorts, are not in them. The same
// points give the same bits. Errors: fewer than 60 points, or most of them fit no device; all lie on one
// plane; the pixels are mirrored.
bool ffp_resect(const double *points, const double *pixels, int n, int width, int height,
                FfpResection *resection, FfpError *err);

#endif
