// Depth from the correspondences that a capture contains (Gray codes).
#ifndef FFP_MATCH_CODED_H
#define FFP_MATCH_CODED_H

#include "core/capture/capture.h"
#include "engine/match/foreground.h"
#include "engine/match/sweep.h"

// Camera depth of pixel i of a view, where its ray comes nearest to the projector position that it saw, and
// how far, in pixels of the projector, it stays away from that: 0 where camera and projector agree. 0 without
// a position, or when the rays meet behind a device.
real ffp_coded_depth(const FfpView *view, size_t pixel, real *off);

// depth [h,w] and trust [h,w] of a view's pixels that have a position, on the object and in its sphere of
// `bounds` radii, replaced: what is known needs no search. Nothing without correspondences.
void ffp_coded_depths(real *depth, real *trust, const FfpCapture *capture, int view, real bounds);

// cost [foreground, count] of such pixels: 0 at the known plane, and rising on both sides.
void ffp_coded_costs(real *cost, const FfpCapture *capture, int view, const FfpForeground *foreground,
                     const FfpPlanes *planes);

#endif
