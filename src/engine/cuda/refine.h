// Common declarations of the sources of engine/refine/table.h's functions.
#ifndef FFP_CUDA_REFINE_H
#define FFP_CUDA_REFINE_H

extern "C" {
#include "core/image/lookup.h"
}

FfpSummed ffp_cuda_summed_new(const FfpImage *rgb);

#endif
