// What the sources of refine/table.h's functions share.
#ifndef FFP_CUDA_REFINE_H
#define FFP_CUDA_REFINE_H

extern "C" {
#include "image/lookup.h"
}

FfpSummed ffp_cuda_summed_new(const FfpImage *rgb);

#endif
