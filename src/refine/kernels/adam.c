// Adam, number by number (refine/adam.h), and the table of one CPU level.
#include "refine/kernels/kernels.h"

void FFP_K(adam_step)(const FfpUpdate *u, real *x, real *mean, real *square, const real *grad,
                      const real *start, int64_t count) {
#pragma omp for simd schedule(static) nowait
    for (int64_t i = 0; i < count; i++) {
        ffp_adam(u, grad[i], &x[i], &mean[i], &square[i]);
        if (start) x[i] -= u->pull * (x[i] - start[i]);
    }
}

const FfpRefineKernels FFP_K(refine) = {
    .adam_step = FFP_K(adam_step), .decode = FFP_K(decode), .pull_back = FFP_K(pull_back)};
