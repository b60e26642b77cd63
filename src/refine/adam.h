// Adam (Kingma and Ba 2015) with a pull back towards the start, number by number: shared by the CPU and the
// GPU. The pull acts on the number and not through the loss, as weight decay does in AdamW (Loshchilov and
// Hutter 2019): Adam would scale it away.
#ifndef FFP_REFINE_ADAM_H
#define FFP_REFINE_ADAM_H

#include <tgmath.h>
#include "refine/parameters.h"

typedef struct FfpUpdate {
    real rate, pull, beta1, beta2, correction1, correction2, epsilon;
} FfpUpdate;

// What one step does to each attribute, and to the number that all roughness logits share.
typedef struct FfpMove {
    FfpUpdate of[FFP_ATTRIBUTES], shared;
    bool shares;
} FfpMove;

// What is kept of the number that all roughness logits share: its moments, and how far it went last.
enum { FFP_SHARED_MEAN, FFP_SHARED_SQUARE, FFP_SHARED_MOVED, FFP_SHARED_NUMBERS };

// Adam's state for parameters, and what holds them near to their start. Arrays are on what the thread works
// on; a device has no neighbours.
typedef struct FfpMover {
    FfpGaussians mean, square, start; // start has no elements unless something pulls towards it
    real *shared;                     // [FFP_SHARED_NUMBERS]
    int64_t *neighbour;               // [count,k]; NULL: no smoothing
    int64_t step;
} FfpMover;

FFP_FORMULA void ffp_adam(const FfpUpdate *u, real g, real *x, real *mean, real *square) {
    *mean = u->beta1 * *mean + (1 - u->beta1) * g;
    *square = u->beta2 * *square + (1 - u->beta2) * g * g;
    *x -= u->rate * *mean * u->correction1 / (sqrt(*square * u->correction2) + u->epsilon);
}

// The number that is shared, from the sum of all gradients to it.
FFP_FORMULA void ffp_adam_shared(const FfpUpdate *u, double sum, real *shared) {
    shared[FFP_SHARED_MOVED] = 0;
    ffp_adam(u, (real)sum, &shared[FFP_SHARED_MOVED], &shared[FFP_SHARED_MEAN], &shared[FFP_SHARED_SQUARE]);
}

#endif
