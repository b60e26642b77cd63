// The loops of a fit that exist once for each CPU level (core/base/level.h).
#ifndef FFP_REFINE_KERNELS_KERNELS_H
#define FFP_REFINE_KERNELS_KERNELS_H

#include "core/base/level.h"
#include "engine/refine/adam.h"

// Of `count` splats from `begin` on (engine/refine/parameters.h).
typedef void FfpDecode(const FfpParameters *p, int64_t begin, int64_t count, const FfpGaussians *out);
typedef void FfpPullBack(const FfpParameters *p, const FfpGaussians *decoded, int64_t begin, int64_t count,
                         const FfpGaussians *grad);

// ffp_adam_coupled of the array's numbers, three at a time, and the pull.
typedef void FfpMoveCoupled(const FfpAdamArray *a, real *cross, int64_t begin, int64_t count);

typedef struct FfpRefineKernels {
    FfpDecode *decode;
    FfpPullBack *pull_back;
    FfpMoveCoupled *move_coupled;
} FfpRefineKernels;

FFP_LOOP_TABLES(FfpRefineKernels, refine)

#ifdef FFP_LEVEL
FfpDecode FFP_K(decode);
FfpPullBack FFP_K(pull_back);
FfpMoveCoupled FFP_K(move_coupled);
#endif

#endif
