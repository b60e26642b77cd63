// Projector matching of one view: depth along each camera ray from the active image.
#ifndef FFP_MATCH_MATCHING_H
#define FFP_MATCH_MATCHING_H

#include "engine/match/match.h"
#include "engine/match/observe.h"
#include "engine/match/stereo.h"
#include "engine/match/sweep.h"

#define FFP_FAR_COST 1e6F // more than any hypothesis costs
#define FFP_OUTSIDE_COST                                                                                     \
    1.0F                      // a channel and a pattern, off the pattern or off a silhouette: as much as a
                              // clearly wrong colour
#define FFP_SMALL_STEP 0.03F  // smoothness: cost of a step of one plane between neighbours
#define FFP_LARGE_STEP 0.3F   // and of any longer one
#define FFP_FITTING_COST 0.1F // mean squared difference above which no hypothesis fits
#define FFP_RIVAL_APART 3     // planes between two separate minima
#define FFP_SEARCH_ROUNDS 2   // of the fine search

// depth [h,w]: camera z, 0 off the object. confidence [h,w]: 1 - best / second-best minimum's cost, times
// lit; 0 where the pixel is not lit, or fits no hypothesis.
// range [h,w,2], or NULL: the camera depths that the other views' silhouettes allow. *hull, if not NULL: the
// result of ffp_hull for the view's hypotheses, which the caller frees.
void ffp_match_view(real *depth, real *confidence, real *range, unsigned char **hull,
                    const FfpCapture *capture, int view, const FfpObservation *observed,
                    const FfpBlurred *patterns, const FfpMatchSettings *settings);

// The same for a view of a whole scene, without hull or silhouettes: costs of the patterns and of the other
// views' photographs are added, so that what is not lit has depth and confidence, too.
void ffp_match_scene_view(real *depth, real *confidence, const FfpStereo *stereo, int view,
                          const FfpObservation *observed, const FfpBlurred *patterns,
                          const FfpMatchSettings *settings);

// Common to both. Cost of a pixel's hypotheses summed over 3 x 3 pixels into `sum` [count]; returns the sum
// of their weights.
real ffp_window_costs(real *sum, const real *cost, const FfpForeground *foreground,
                      const FfpObservation *observed, int x, int y, int count);
// Least value at a minimum some planes away from `chosen`; the greatest value when there is none. `sum` has a
// cell of FFP_FAR_COST before and behind.
real ffp_rival_cost(const real *sum, int count, int chosen);
int ffp_least_cost(const real *values, int count); // its index, the first

// Bytes of working memory that one view takes at most while it is matched.
size_t ffp_match_bytes(const FfpCamera *camera, const FfpMatchSettings *settings);

#endif
