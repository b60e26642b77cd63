// The turntable's axis as an unknown, and the motion about it.
#ifndef FFP_RIG_AXIS_H
#define FFP_RIG_AXIS_H

#include <stdbool.h>
#include "core/base/rigid.h"

// A line in camera coordinates about which the object turns, right-handed about the direction.
typedef struct FfpAxis {
    double direction[3]; // unit vector
    double point[3];     // of the line, best near the object
} FfpAxis;

// Where a point before the camera goes when the object turns by an angle (radians): R(u, angle) (X - p) + p.
// Rodrigues' formula.
void ffp_axis_rotate(const FfpAxis *axis, double angle, const double point[3], double out[3]);
// The same of a direction.
void ffp_axis_rotate_direction(const FfpAxis *axis, double angle, const double direction[3], double out[3]);

// An axis moved by small numbers: 0, 1: tilt about its point, radians, towards two directions across it; 2:
// sideways as the camera sees it, in distances of the point; 3: logarithm of the distance of the point.
enum { FFP_AXIS_TILT, FFP_AXIS_SIDEWAYS = 2, FFP_AXIS_DISTANCE = 3, FFP_AXIS_NUMBERS = 4 };
void ffp_axis_move(const FfpAxis *from, const double by[FFP_AXIS_NUMBERS], FfpAxis *to);

// Differences that vanish at the right axis. `residuals` [count] gets them in any unit, INFINITY where there
// is none.
typedef struct FfpAxisTerm {
    void (*residuals)(const void *context, const FfpAxis *axis, double *residuals);
    const void *context;
    int count;
    double scale;  // a residual of this size is large: beyond it counts less and less
    double weight; // of each
    bool optional; // what is not there costs nothing; otherwise as much as what is far off
} FfpAxisTerm;

// Least squares by Levenberg and Marquardt with numeric derivatives, robust by the function of Geman and
// McClure (r^2 / (1 + r^2), r in units of the scale). Moves the first `numbers` of the four. Returns the mean
// cost, from 0 to 1. `covariance` [numbers^2] or NULL: from the residuals left over; all INFINITY where they
// do not say.
double ffp_axis_fit(FfpAxis *axis, int numbers, const FfpAxisTerm *terms, int n_terms, int steps,
                    double *covariance);

// Median of the absolute values of those that exist; their number in *there.
double ffp_axis_median(const FfpAxisTerm *term, const FfpAxis *axis, int *there);

#endif
