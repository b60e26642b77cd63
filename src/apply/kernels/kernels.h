// The loops of compensation that exist once for each CPU level (base/level.h).
#ifndef FFP_APPLY_KERNELS_KERNELS_H
#define FFP_APPLY_KERNELS_KERNELS_H

#include "base/level.h"
#include "base/real.h"
#include <stddef.h>

// One step of Adam within [0,1]. `small` keeps places that hardly matter from moving as fast as the others.
typedef struct FfpDescent {
    real beta1, beta2, correct1, correct2, rate, small;
} FfpDescent;
typedef void FfpDescend(const FfpDescent *descent, real *value, real *mean, real *square,
                        const real *gradient, size_t count);

typedef struct FfpApplyKernels {
    FfpDescend *descend;
} FfpApplyKernels;

FFP_LOOP_TABLES(FfpApplyKernels, apply)

#ifdef FFP_LEVEL
FfpDescend FFP_K(descend);
#endif

#endif
