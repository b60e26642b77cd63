// Depth of pixels that the projector does not light: by stereo on the pictures under black.
#ifndef FFP_MATCH_UNLIT_H
#define FFP_MATCH_UNLIT_H

#include "engine/match/consistency.h"
#include "engine/match/match.h"

// out [views,h,w]: the depth that `filled` [views,h,w] gives, and where the pixel has no trusted one, another
// plane's if colours under black, silhouettes and the rays of trusted points, the cameras' and the
// projectors', speak clearly for it. `threads` views are worked on at a time.
// hulls [views], or NULL: what ffp_hull says of each view's hypotheses.
void ffp_unlit_depths(real *out, const FfpDepths *depths, const real *filled, unsigned char *const *hulls,
                      const FfpMatchSettings *settings, int threads);

#endif
