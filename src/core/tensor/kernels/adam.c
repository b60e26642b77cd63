// Adam's step (core/tensor/adam.h).
#include "core/tensor/kernels/kernels.h"

// Shared out among the threads of the parallel region, which do not wait for each other.
static void move(const FfpAdamArray *a) {
    const FfpAdamStep s = a->step;
    real *x = a->x, *mean = a->mean, *square = a->square, *average = a->average;
    const real *grad = a->grad, *start = a->start;
#pragma omp for simd schedule(static) nowait
    for (int64_t i = 0; i < a->count; i++) {
        ffp_adam_move(&s, grad[i], &x[i], &mean[i], &square[i]);
        if (start) x[i] = ffp_adam_pulled(&s, x[i], start[i]);
        if (average) average[i] = ffp_adam_average(&s, average[i], x[i]);
    }
}

void FFP_K(adam)(const FfpAdamArray *arrays, int n) {
#pragma omp parallel
    for (int k = 0; k < n; k++) move(&arrays[k]);
}
