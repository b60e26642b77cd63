// Projector matching of one view: depth along each camera ray from the active image.
#ifndef FFP_MATCH_MATCHING_H
#define FFP_MATCH_MATCHING_H

#include "engine/match/match.h"
#include "engine/match/observe.h"

// depth [h,w]: camera z, 0 off the object. confidence [h,w]: 1 - best / second-best minimum's cost, times
// lit; 0 where the pixel is not lit, or fits no hypothesis.
// range [h,w,2], or NULL: the camera depths that the other views' silhouettes allow. *hull, if not NULL: the
// result of ffp_hull for the view's hypotheses, which the caller frees.
void ffp_match_view(real *depth, real *confidence, real *range, unsigned char **hull,
                    const FfpCapture *capture, int view, const FfpObservation *observed,
                    const FfpBlurred *patterns, const FfpMatchSettings *settings);

// Bytes of working memory that one view takes at most while it is matched.
size_t ffp_match_bytes(const FfpCamera *camera, const FfpMatchSettings *settings);

#endif
