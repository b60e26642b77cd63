// The loops of a fit that exist once for each CPU level (base/level.h).
#ifndef FFP_REFINE_KERNELS_KERNELS_H
#define FFP_REFINE_KERNELS_KERNELS_H

#include "base/level.h"
#include "refine/adam.h"
#include "refine/parameters.h"

// One step of `count` numbers, shared out among the threads of the parallel region that it is called in,
// which do not wait for each other; start NULL: nothing pulls.
typedef void FfpAdamStep(const FfpUpdate *u, real *x, real *mean, real *square, const real *grad,
                         const real *start, int64_t count);

// Of `count` splats from `begin` on (refine/parameters.h).
typedef void FfpDecode(const FfpParameters *p, int64_t begin, int64_t count, const FfpGaussians *out);
typedef void FfpPullBack(const FfpParameters *p, const FfpGaussians *decoded, int64_t begin, int64_t count,
                         const FfpGaussians *grad);

typedef struct FfpRefineKernels {
    FfpAdamStep *adam_step;
    FfpDecode *decode;
    FfpPullBack *pull_back;
} FfpRefineKernels;

FFP_LOOP_TABLES(FfpRefineKernels, refine)

#ifdef FFP_LEVEL
FfpAdamStep FFP_K(adam_step);
FfpDecode FFP_K(decode);
FfpPullBack FFP_K(pull_back);
#endif

#endif
