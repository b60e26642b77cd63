// Views of one fixed rig around a turning object: the parameters that their poses share.
#ifndef FFP_ALIGN_RING_H
#define FFP_ALIGN_RING_H

#include "core/base/rigid.h"
#include "engine/align/align.h"

typedef struct FfpRing {
    int views;
    FfpRigid camera, projector;       // of the first view
    double axis[3], point[3], *angle; // unit axis, a point on it, [views] radians from the first view
    double across[2][3];              // two directions perpendicular to the axis
    double misfit; // root mean square difference from the given poses, in units of the expected errors
} FfpRing;

// The ring nearest to the capture's poses, by least squares weighted with their expected errors. False with
// fewer than four views, or if no two of them differ by a rotation.
bool ffp_ring_fit(FfpRing *ring, const FfpCapture *capture, const FfpPoseErrors *expected);
void ffp_ring_free(FfpRing *ring);
void ffp_ring_place(const FfpRing *ring, FfpCapture *capture); // gives the capture the ring's poses

#endif
