// Adam on a pattern's values, and the table of one CPU level.
#include <tgmath.h>
#include "apply/kernels/kernels.h"

void FFP_K(descend)(const FfpDescent *d, real *value, real *mean, real *square, const real *gradient,
                    size_t count) {
#pragma omp parallel for schedule(static)
    for (size_t i = 0; i < count; i++) {
        mean[i] += (1 - d->beta1) * (gradient[i] - mean[i]);
        square[i] += (1 - d->beta2) * (gradient[i] * gradient[i] - square[i]);
        const real moved = mean[i] / d->correct1 / (sqrt(square[i] / d->correct2) + d->small);
        value[i] = fmin(fmax(value[i] - d->rate * moved, (real)0), (real)1);
    }
}

const FfpApplyKernels FFP_K(apply) = {.descend = FFP_K(descend)};
