// The positions of lit surfaces, from the colours projected on them: coarse, but without a sphere to search
// in. For captures whose devices look in nearly the same direction, so that their axes do not give the
// position.
#ifndef FFP_CAPTURE_COARSE_DEPTH_H
#define FFP_CAPTURE_COARSE_DEPTH_H

#include "core/capture/capture.h"

#define FFP_COARSE_POINTS_MAX 2400

// World points of lit surfaces, from the pictures under black, white and all other patterns that a view has.
// Each view's pixels vote together for the camera depth at which all of them fit best; each pixel then takes
// its own best depth near it. Returns the number of points; 0 if no view has a pattern to use, or if no depth
// fits clearly better than the others and `guess` (NULL: none), an independent estimate of the object's
// position, is as good.
int ffp_coarse_points(const FfpCapture *capture, const double guess[3],
                      real points[FFP_COARSE_POINTS_MAX][3]);

// The same without a common depth, for scenes that have none: the points of those samples whose colours fit
// one depth clearly better than most others.
int ffp_clear_points(const FfpCapture *capture, real points[FFP_COARSE_POINTS_MAX][3]);

#endif
