// The coarse search: costs of depth hypotheses for every pixel of a view, and the smooth surface of least
// cost.
#ifndef FFP_MATCH_SWEEP_H
#define FFP_MATCH_SWEEP_H

#include "engine/match/foreground.h"
#include "engine/match/match.h"
#include "engine/match/observe.h"

// Hypotheses: planes of equal camera depth, evenly spaced over the object's sphere.
typedef struct FfpPlanes {
    int count;
    real first, step; // camera depth
} FfpPlanes;
FfpPlanes ffp_planes(const FfpCapture *capture, int view, const FfpMatchSettings *settings);

// inside [foreground, count]: 1 where a hypothesis lies within the silhouettes of all other views, widened by
// a pixel; what is outside a picture is not known to be empty.
void ffp_hull(unsigned char *inside, const FfpCapture *capture, int view, const FfpForeground *foreground,
              const FfpPlanes *planes);
// The camera depths between which each pixel's ray is within the hull, [h,w,2]; the whole sphere where it
// never is, or off the object.
void ffp_hull_range(real *range, const unsigned char *inside, const FfpForeground *foreground,
                    const FfpPlanes *planes);
// The same for a single view.
void ffp_hull_ranges(real *range, const FfpCapture *capture, int view);

// cost [foreground, count] of a view's pixels: squared difference between the observed ratio and the pattern
// where the hypothesis puts it, summed over channels with their weights and over the view's patterns, which
// count alike because noise is one for all photographs; hypotheses outside the hull cost as much as a wrong
// colour.
void ffp_sweep(real *cost, const FfpView *view, const FfpForeground *foreground,
               const FfpObservation *observed, const FfpBlurred *patterns, const FfpPlanes *planes,
               const unsigned char *inside);

// Semi-global aggregation (Hirschmueller 2008) over eight directions within the foreground: added to
// total [foreground, count]. Steps of one plane between neighbours cost `small`, longer ones `large`.
void ffp_semi_global(real *total, const real *cost, const FfpForeground *foreground, int count, real small,
                     real large);

#endif
