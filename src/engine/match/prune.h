// Splats that contradict the photographs.
#ifndef FFP_MATCH_PRUNE_H
#define FFP_MATCH_PRUNE_H

#include <stdint.h>
#include "engine/match/match.h"

// Sets the opacity [count] of splats to 0 whose centres [count,3] lie where a silhouette or the rays of
// matched points, a camera's or a projector's, show the space to be empty: those of the views that the
// splat's own asks (ffp_asked). pixel [count]: the splats' in the start's maps. Returns their number. For a
// capture that was matched on reduced pictures, these are used.
int64_t ffp_prune_contradicted(real *opacity, const real *centre, const int64_t *pixel, int64_t count,
                               const FfpCapture *capture, const FfpInitialisation *start);

// The same for the silhouettes of two views alone: after a fit, which moves splats, also past an outline that
// one view has a little too narrow. Not for whole scenes, which have none.
int64_t ffp_prune_off_silhouettes(real *opacity, const real *centre, int64_t count,
                                  const FfpCapture *capture);

#endif
