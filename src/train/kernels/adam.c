// AdamW, number by number (train/table.h), and the table of one CPU level.
#include "train/kernels/kernels.h"

void FFP_K(adam_move)(const FfpAdamRates *rates, real *w, real *m, real *v, real *ema, const real *grad,
                      int64_t count) {
#pragma omp parallel for simd schedule(static)
    for (int64_t i = 0; i < count; i++) ffp_adam_move(rates, w + i, m + i, v + i, ema + i, grad[i]);
}

const FfpTrainKernels FFP_K(train) = {.adam_move = FFP_K(adam_move)};
