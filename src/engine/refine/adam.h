// Adam (core/tensor/adam.h) of the numbers of Gaussians, with a pull back towards their start: shared by the
// CPU and the GPU.
#ifndef FFP_REFINE_ADAM_H
#define FFP_REFINE_ADAM_H

#include "core/tensor/adam.h"
#include "engine/refine/parameters.h"

// The step for each attribute, and for the number that all roughness logits share.
typedef struct FfpGaussianAdamStep {
    FfpAdamStep of[FFP_ATTRIBUTES], shared;
    bool shares;
} FfpGaussianAdamStep;

// The state of the number that all roughness logits share: its moments, and its last change.
enum { FFP_SHARED_MEAN, FFP_SHARED_SQUARE, FFP_SHARED_MOVED, FFP_SHARED_NUMBERS };

// Adam's state for the parameters, and the terms that keep them close to their start. Arrays are in the
// memory of the device that the thread works on; on a GPU there are no neighbours.
typedef struct FfpGaussianAdam {
    FfpGaussians mean, square, start; // start has no elements unless something pulls towards it
    real *cross;                      // [count,3] of the centres (ffp_adam_coupled); NULL: not coupled
    real *shared;                     // [FFP_SHARED_NUMBERS]
    int64_t *neighbour;               // [count,k]; NULL: no smoothing
    int64_t step;
} FfpGaussianAdam;

// The number that is shared, from the sum of all gradients to it.
FFP_FORMULA void ffp_adam_shared(const FfpAdamStep *step, double sum, real *shared) {
    shared[FFP_SHARED_MOVED] = 0;
    ffp_adam_move(step, (real)sum, &shared[FFP_SHARED_MOVED], &shared[FFP_SHARED_MEAN],
                  &shared[FFP_SHARED_SQUARE]);
}

// A step of three numbers whose gradients g agree in part, as those of a centre do: cross[k] is the second
// moment between the other two. With u Adam's step and R the correlations, the numbers take ((1 + R) / 2)^-1
// u: to first order in R that is R^-1/2 u, as Adam with the full matrix would go (Duchi et al. 2011, section
// 1.1): a direction that the looks agree on moves at least half as far, one that none of them tells up to
// twice as far.
FFP_FORMULA void ffp_adam_coupled(const FfpAdamStep *s, const real g[3], real x[3], real mean[3],
                                  real square[3], real cross[3]) {
    real u[3], per[3], r[3];
    for (int k = 0; k < 3; k++) {
        mean[k] = s->beta1 * mean[k] + (1 - s->beta1) * g[k];
        square[k] = s->beta2 * square[k] + (1 - s->beta2) * g[k] * g[k];
        per[k] = 1 / (sqrt(square[k] * s->correction2) + s->epsilon);
        u[k] = mean[k] * s->correction1 * per[k];
    }
    cross[0] = s->beta2 * cross[0] + (1 - s->beta2) * g[1] * g[2];
    cross[1] = s->beta2 * cross[1] + (1 - s->beta2) * g[2] * g[0];
    cross[2] = s->beta2 * cross[2] + (1 - s->beta2) * g[0] * g[1];
    const real half = s->correction2 / 2;
    r[0] = half * cross[0] * per[1] * per[2];
    r[1] = half * cross[1] * per[2] * per[0];
    r[2] = half * cross[2] * per[0] * per[1];
    const real a = r[1] * r[2] - r[0], b = r[2] * r[0] - r[1], c = r[0] * r[1] - r[2];
    const real by = s->rate / (1 - r[0] * r[0] + r[1] * b + r[2] * c); // at least 1/2
    x[0] -= by * ((1 - r[0] * r[0]) * u[0] + c * u[1] + b * u[2]);
    x[1] -= by * (c * u[0] + (1 - r[1] * r[1]) * u[1] + a * u[2]);
    x[2] -= by * (b * u[0] + a * u[1] + (1 - r[2] * r[2]) * u[2]);
}

#endif
