// The large planes of a whole scene, walls and floors, and which of its unlit pixels show them: what no
// pattern reaches and no photograph tells lies, more often than not, on a plane that is known elsewhere.
#ifndef FFP_MATCH_LAYOUT_H
#define FFP_MATCH_LAYOUT_H

#include "engine/match/consistency.h"

// depth [views,h,w]: where a pixel has no trusted depth, `filled` [views,h,w] or the depth of a plane that
// trusted points lie on, whichever agrees better with the colours under black, with the rays of trusted
// points and with the pixels around. normals [views,h,w,3]: of trusted points. lit [views,h,w] as in
// FfpInitialisation.
void ffp_layout_depths(real *depth, const FfpDepths *depths, const real *normals, const real *filled,
                       const real *lit);

#endif
