// The base of a Gaussian's formulas, from a pixel of the classical initialisation; the formulas themselves
// are in splat_formula.h.
#ifndef FFP_NETWORK_SPLAT_H
#define FFP_NETWORK_SPLAT_H

#include <stdint.h>
#include "engine/match/match.h"
#include "engine/network/splat_formula.h"

// Fills the residual form's fields from pixel `pixel` of the start; direction and nearest must be set.
void ffp_residual_base(FfpPixelBase *base, const FfpInitialisation *start, int64_t pixel);

#endif
