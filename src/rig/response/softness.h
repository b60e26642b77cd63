// How soft the projector's pictures are where they land, near and far.
#ifndef FFP_RIG_SOFTNESS_H
#define FFP_RIG_SOFTNESS_H

#include "rig/response/spread.h"

typedef struct FfpSoftness {
    double blur;      // deviation, pixels of the ideal projector; 0: none found
    FfpSpread spread; // beside the blur
} FfpSoftness;

// From photographs under patterns as they are in their files, where Gray codes place the pixels, or without
// codes where matching trusts its depth.
FfpSoftness ffp_fit_softness(const FfpCapture *capture);

#endif
