// The loops of training that exist once for each CPU level (base/level.h).
#ifndef FFP_TRAIN_KERNELS_KERNELS_H
#define FFP_TRAIN_KERNELS_KERNELS_H

#include "base/level.h"
#include "train/table.h"

// One update of `count` weights.
typedef void FfpAdamMove(const FfpAdamRates *rates, real *w, real *m, real *v, real *ema, const real *grad,
                         int64_t count);

typedef struct FfpTrainKernels {
    FfpAdamMove *adam_move;
} FfpTrainKernels;

FFP_LOOP_TABLES(FfpTrainKernels, train)

#ifdef FFP_LEVEL
FfpAdamMove FFP_K(adam_move);
#endif

#endif
