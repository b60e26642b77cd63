// The loops of a fit that exist once for each CPU level (base/level.h).
#ifndef FFP_REFINE_KERNELS_KERNELS_H
#define FFP_REFINE_KERNELS_KERNELS_H

#include "base/level.h"
#include "refine/adam.h"

// One step of `count` numbers; start NULL: nothing pulls.
typedef void FfpAdamStep(const FfpUpdate *u, real *x, real *mean, real *square, const real *grad,
                         const real *start, int64_t count);

typedef struct FfpRefineKernels {
    FfpAdamStep *adam_step;
} FfpRefineKernels;

FFP_LOOP_TABLES(FfpRefineKernels, refine)

#ifdef FFP_LEVEL
FfpAdamStep FFP_K(adam_step);
#endif

#endif
