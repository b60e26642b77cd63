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

// inside [h,w,count]: 1 where a hypothesis lies within the silhouettes of all other views, widened by a
// pixel; what is outside a picture is not known to be empty. 0 off the object.
void ffp_hull(unsigned char *inside, const FfpCapture *capture, int view, const FfpPlanes *planes);
// The camera depths between which a pixel's ray is within the hull; the whole sphere where it never is.
void ffp_hull_range(real range[2], const unsigned char *inside, const FfpPlanes *planes);
// The same for all pixels of a view, [h,w,2].
void ffp_hull_ranges(real *range, const FfpCapture *capture, int view);

// cost [h,w,count] of a view's pixels: squared difference between the observed ratio and the pattern where
// the hypothesis puts it, summed over channels with their weights; hypotheses outside the hull cost as much
// as a wrong colour. Zero off the object.
void ffp_sweep(real *cost, const FfpView *view, const FfpObservation *seen, const FfpBlurred *pattern,
               const FfpPlanes *planes, const unsigned char *inside);

// Semi-global aggregation (Hirschmueller 2008) over eight directions within the mask: total [h,w,count],
// zeroed by the caller. Steps of one plane between neighbours cost `small`, longer ones `large`.
void ffp_semi_global(real *total, const real *cost, const real *mask, int width, int height, int count,
                     real small, real large);

#endif
