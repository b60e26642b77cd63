// A device from points and where it has them, by linear equations (Abdel-Aziz and Karara 1971).
#ifndef FFP_NUMERICS_PROJECTION_H
#define FFP_NUMERICS_PROJECTION_H

#include <stdbool.h>
#include "core/base/rigid.h"

typedef struct FfpLinearDevice {
    double focal, x, y; // of the unit of the positions
    FfpRigid pose;      // the points' frame to the device's
    bool mirrored;
} FfpLinearDevice;

// From n points [n,3] and their positions [n,2], which should be a few units around 0; those count whose
// `use` [n] is not 0, which each of `rounds` but the last takes from those four times the median off. False:
// the equations have no solution, as those of points on one plane.
bool ffp_projection_find(const double *points, const double *positions, unsigned char *use, int n, int rounds,
                         FfpLinearDevice *projection);
// How far half of n points [n,3] of a device's frame lie from the plane that fits them best, as shares of
// their distance; 0: there are none.
double ffp_off_plane(const double *points, int n);

#endif
