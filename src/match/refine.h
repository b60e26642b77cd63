// The fine search: depth of lit pixels along the local plane, to a fraction of a step.
#ifndef FFP_MATCH_REFINE_H
#define FFP_MATCH_REFINE_H

#include "match/observe.h"
#include "match/surface.h"

// Searches `steps` hypotheses about each pixel's local plane, range / (steps / 2) apart (camera depth), from
// -range to one step below +range; the pixels around it move along with that plane. Reads `depth` and writes
// `out` [h,w]; pixels without depth or with weight 0 keep theirs.
void ffp_refine_depth(real *out, const real *depth, const real *weight, const FfpView *view,
                      const FfpObservation *seen, const FfpBlurred *patterns, int steps, real range);

#endif
