// The fine search: depth of lit pixels along the local plane, to a fraction of a step.
#ifndef FFP_MATCH_REFINE_H
#define FFP_MATCH_REFINE_H

#include "engine/match/observe.h"
#include "engine/match/surface.h"

// A view, and the settings of its search.
typedef struct FfpFineSearch {
    const FfpCamera *camera, *projector;
    const FfpObservation *observed;
    const FfpBlurred *patterns;
    int steps;    // hypotheses, up to FFP_REFINE_STEPS_MAX
    bool inverse; // the range searched is of inverse depth
} FfpFineSearch;

enum { FFP_REFINE_STEPS_MAX = 256, FFP_FINE_PLANE_REACH = 2 }; // the local plane is fitted to as many pixels

// Searches `steps` hypotheses about each pixel's local plane, range / (steps / 2) apart (camera depth, or its
// inverse), from -range to one step below +range; the pixels around it move along with that plane. Reads
// `depth` and writes `out` [h,w]; pixels without depth or with weight 0 keep theirs.
void ffp_refine_depth(real *out, const real *depth, const real *weight, const FfpFineSearch *search,
                      real range);

#endif
