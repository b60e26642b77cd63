// Depth for pixels whose own view gives none.
#ifndef FFP_MATCH_FILL_H
#define FFP_MATCH_FILL_H

#include "engine/match/consistency.h"

// Fills the pixels of depth 0 inside `mask` (NULL: everywhere) from the others. Without a range the
// continuation is the smoothest (harmonic) one of depth; with range [h,w,2], where the surface may lie, it is
// that of the distance behind the range's near end, and kept within the range: an unseen surface follows the
// visual hull. Pixels that no known one is connected to within the mask stay 0.
void ffp_fill_smoothly(real *depth, const real *mask, const real *range, int width, int height);

// Depth [h,w] of `view` where it has no trusted one, from the trusted points of the other views that project
// there, the nearest first; points whose surface faces away do not count. normals [views,h,w,3]: world, of
// the trusted points. The view's own untrusted depths are dropped: 0 where no point came.
void ffp_fill_from_others(real *out, const FfpDepths *depths, const real *normals, int view);

#endif
