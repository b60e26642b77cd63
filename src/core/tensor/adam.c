// The part of Adam that is the same at every CPU level.
#include "core/tensor/adam.h"
#include "core/base/alloc.h"
#include "core/tensor/kernels/kernels.h"

FfpAdamStep ffp_adam_step(double rate, double beta1, double beta2, double epsilon, int64_t step) {
    return (FfpAdamStep){.rate = (real)rate,
                         .beta1 = (real)beta1,
                         .beta2 = (real)beta2,
                         .epsilon = (real)epsilon,
                         .correction1 = (real)(1 / (1 - pow(beta1, (double)step))),
                         .correction2 = (real)(1 / (1 - pow(beta2, (double)step))),
                         .scale = 1};
}

double ffp_plain_squared_norm(const real *x, int64_t count) {
    enum { BLOCK = 1 << 14 };
    const int64_t blocks = (count + BLOCK - 1) / BLOCK;
    double *partial = ffp_alloc((size_t)blocks, sizeof *partial);
#pragma omp parallel for schedule(static)
    for (int64_t b = 0; b < blocks; b++) {
        const int64_t end = (b + 1) * BLOCK < count ? (b + 1) * BLOCK : count;
        double sum = 0;
        for (int64_t i = b * BLOCK; i < end; i++) sum += (double)x[i] * x[i];
        partial[b] = sum;
    }
    double total = 0;
    for (int64_t b = 0; b < blocks; b++) total += partial[b];
    ffp_free(partial);
    return total;
}
