// Views of one fixed rig around a turning object: what their poses have in common.
#ifndef FFP_ALIGN_RING_H
#define FFP_ALIGN_RING_H

#include "core/base/rigid.h"
#include "engine/align/align.h"

typedef struct FfpRing {
    int views;
    FfpRigid camera, projector;       // of the first view
    double axis[3], point[3], *angle; // unit axis, a point on it, [views] radians from the first view
    double across[2][3];              // two directions across the axis
    double misfit; // root mean square of what the given poses differ by, in units of what is expected
} FfpRing;

// The ring nearest to the capture's poses, in the least squares of what is expected to be wrong with them.
// False with fewer than four views, or when no two differ by a turn.
bool ffp_ring_fit(FfpRing *ring, const FfpCapture *capture, const FfpPoseErrors *expected);
void ffp_ring_free(FfpRing *ring);
void ffp_ring_place(const FfpRing *ring, FfpCapture *capture); // gives the capture the ring's poses

#endif
