// Depth of pixels that the projector does not light: by stereo on the pictures under black.
#ifndef FFP_MATCH_UNLIT_H
#define FFP_MATCH_UNLIT_H

#include "engine/match/consistency.h"
#include "engine/match/match.h"

// out [views,h,w]: the depth in `filled` [views,h,w] or, for a pixel without a trusted one, that of another
// plane if colours under black, silhouettes and the rays of trusted points, of cameras and projectors,
// clearly favour it. `threads` views are processed at a time. hulls [views], or NULL: the results of ffp_hull
// for each view's hypotheses.
void ffp_unlit_depths(real *out, const FfpDepths *depths, const real *filled, unsigned char *const *hulls,
                      const FfpMatchSettings *settings, int threads);

#endif
