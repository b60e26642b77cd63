// The coarse search: costs of depth hypotheses for every pixel of a view, and the smooth surface of least
// cost.
#ifndef FFP_MATCH_SWEEP_H
#define FFP_MATCH_SWEEP_H

#include "match/match.h"
#include "match/observe.h"

// Hypotheses: planes of equal camera depth, evenly spaced over the object's sphere.
typedef struct FfpPlanes {
    int count;
    real first, step; // camera depth
} FfpPlanes;
FfpPlanes ffp_planes(const FfpCapture *capture, int view, const FfpMatchSettings *settings);

// cost [h,w,count] of a view's pixels: squared difference between the observed ratio and the pattern where
// the hypothesis puts it, summed over channels with their weights. Zero off the object. `hull`: hypotheses
// that lie outside the silhouette of any other view, widened by a pixel, cost as much as a wrong colour.
void ffp_sweep(real *cost, const FfpCapture *capture, int view, const FfpObservation *seen,
               const FfpBlurred *pattern, const FfpPlanes *planes, bool hull);

// Semi-global aggregation (Hirschmueller 2008) over eight directions within the mask: total [h,w,count],
// zeroed by the caller. Steps of one plane between neighbours cost `small`, longer ones `large`.
void ffp_semi_global(real *total, const real *cost, const real *mask, int width, int height, int count,
                     real small, real large);

#endif
