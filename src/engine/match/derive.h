// The maps of an initialisation that are derived from depths.
#ifndef FFP_MATCH_DERIVE_H
#define FFP_MATCH_DERIVE_H

#include "engine/match/consistency.h"
#include "engine/match/match.h"

// The position of each pixel's point along its ray, and its support by the other views of `depths`, which may
// be those of reduced pictures. depth [views,h,w]: camera z at the size of `initial`.
void ffp_judge(FfpInitialisation *initial, const FfpCapture *capture, const real *depth,
               const FfpDepths *depths);

// Everything that is derived from trusted depths. Takes ownership of depths->depth and ->trust: trust becomes
// the confidence. hulls: as in ffp_unlit_depths.
void ffp_derive(FfpInitialisation *initial, FfpDepths *depths, real *range, unsigned char *const *hulls,
                const FfpMatchSettings *settings, int threads);

#endif
