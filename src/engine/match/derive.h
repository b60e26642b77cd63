// What follows from depths: the maps of an initialisation.
#ifndef FFP_MATCH_DERIVE_H
#define FFP_MATCH_DERIVE_H

#include "engine/match/consistency.h"
#include "engine/match/match.h"

// Where each pixel's point lies along its ray, and what the other views of `depths`, which may be those of
// reduced pictures, say of it. depth [views,h,w]: camera z at the size of `initial`.
void ffp_judge(FfpInitialisation *initial, const FfpCapture *capture, const real *depth,
               const FfpDepths *depths);

// Everything that follows from trusted depths. Takes depths->depth and ->trust over: trust becomes the
// confidence. hulls: as ffp_unlit_depths'.
void ffp_derive(FfpInitialisation *initial, FfpDepths *depths, real *range, unsigned char *const *hulls,
                const FfpMatchSettings *settings, int threads);

#endif
