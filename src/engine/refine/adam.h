// Adam (core/tensor/adam.h) of the numbers of Gaussians, with a pull back towards their start: shared by the
// CPU and the GPU.
#ifndef FFP_REFINE_ADAM_H
#define FFP_REFINE_ADAM_H

#include "core/tensor/adam.h"
#include "engine/refine/parameters.h"

// What one step does to each attribute, and to the number that all roughness logits share.
typedef struct FfpGaussianAdamStep {
    FfpAdamStep of[FFP_ATTRIBUTES], shared;
    bool shares;
} FfpGaussianAdamStep;

// What is kept of the number that all roughness logits share: its moments, and how far it went last.
enum { FFP_SHARED_MEAN, FFP_SHARED_SQUARE, FFP_SHARED_MOVED, FFP_SHARED_NUMBERS };

// Adam's state for parameters, and what holds them near to their start. Arrays are on what the thread works
// on; a device has no neighbours.
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
