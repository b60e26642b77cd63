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

#endif
