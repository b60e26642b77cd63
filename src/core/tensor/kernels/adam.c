// Adam's step (core/tensor/adam.h).
#include "core/tensor/kernels/kernels.h"

// Of one kind: what is constant here needs no masked stores, which cost more than the step itself.
static inline __attribute__((always_inline)) void move_as(const FfpAdamArray *a, const bool sparse,
                                                          const bool pulls, const bool averages) {
    FfpAdamStep s = a->step;
    s.sparse = sparse;
    real *x = a->x, *mean = a->mean, *square = a->square, *average = a->average;
    const real *grad = a->grad, *start = a->start;
#pragma omp for simd schedule(static) nowait
    for (int64_t i = 0; i < a->count; i++) {
        ffp_adam_move(&s, grad[i], &x[i], &mean[i], &square[i]);
        if (pulls) x[i] = ffp_adam_pulled(&s, x[i], start[i]);
        if (averages) average[i] = ffp_adam_average(&s, average[i], x[i]);
    }
}

// Shared out among the threads of the parallel region, which do not wait for each other.
static void move(const FfpAdamArray *a) {
    const bool pulls = a->start, averages = a->average;
    if (a->step.sparse)
        move_as(a, true, pulls, averages);
    else if (pulls && averages)
        move_as(a, false, true, true);
    else if (pulls)
        move_as(a, false, true, false);
    else if (averages)
        move_as(a, false, false, true);
    else
        move_as(a, false, false, false);
}

void FFP_K(adam)(const FfpAdamArray *arrays, int n) {
#pragma omp parallel
    for (int k = 0; k < n; k++) move(&arrays[k]);
}
