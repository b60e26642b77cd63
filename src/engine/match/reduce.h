// Large captures are matched on reduced pictures: the work and the reach of every window then depend on the
// object's size in the world, not on how finely it was photographed.
#ifndef FFP_MATCH_REDUCE_H
#define FFP_MATCH_REDUCE_H

#include "engine/match/match.h"

// A capture of reduced pictures and the start matched on it.
typedef struct FfpReduced {
    FfpCapture capture; // borrows patterns; its views have black, white, what they show of the
                        // patterns, and the coverage
    FfpInitialisation start;
} FfpReduced;

// The factor by which each side is reduced, at least 1: such that a view shows the object, on average over
// the views, in no more pixels than matching has memory for. 1 for any picture of 32,768 pixels or fewer.
int ffp_reduction(const FfpCapture *capture);
int ffp_reduction_of(double pixels); // the same from the object's mean number of pixels in a view

#endif
