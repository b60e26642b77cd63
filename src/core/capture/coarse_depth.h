// Where lit surfaces are, from the colours that the projector sent there: coarse, but without any sphere to
// search in. For captures whose devices look nearly the same way, so that their axes do not tell.
#ifndef FFP_CAPTURE_COARSE_DEPTH_H
#define FFP_CAPTURE_COARSE_DEPTH_H

#include "core/capture/capture.h"

#define FFP_COARSE_POINTS_MAX 2400

// World points of lit surfaces, from the pictures under black, white and all other patterns that a view has.
// Each view's pixels vote together: the camera depth at which all of them fit best, with some depth of the
// object around it, is that at which each then takes its own best. Returns how many points; 0 when no view
// has a pattern to look at, or when no depth fits clearly better than the others and `guess` (NULL: there is
// none), a point that something else says the object to be at, is as good.
int ffp_coarse_points(const FfpCapture *capture, const double guess[3],
                      real points[FFP_COARSE_POINTS_MAX][3]);

#endif
