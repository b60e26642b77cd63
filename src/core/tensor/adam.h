// Adam (Kingma and Ba 2015): everything that learns by gradients here takes this step. Differences are
// parameters. CPU and GPU share the formula.
#ifndef FFP_TENSOR_ADAM_H
#define FFP_TENSOR_ADAM_H

#include <stdbool.h>
#include <stdint.h>
#include <tgmath.h>
#include "core/base/real.h"

typedef struct FfpAdamStep {
    real rate, beta1, beta2, epsilon;
    real correction1, correction2; // factors of the moments, which begin at 0
    real scale;                    // of the gradients
    real decay;   // share of a number that the step takes away, as in AdamW (Loshchilov and Hutter 2019)
    real pull;    // share of the way back to `start`, after the step. In the loss, Adam would scale it away
    real average; // share of the running average that is kept
    bool sparse;  // a number whose gradient is 0 is left unchanged, and so are its moments
} FfpAdamStep;

// Step number `step`, from 1 on; neither decay nor pull.
FfpAdamStep ffp_adam_step(double rate, double beta1, double beta2, double epsilon, int64_t step);

FFP_FORMULA void ffp_adam_move(const FfpAdamStep *s, real grad, real *x, real *mean, real *square) {
    const real g = grad * s->scale;
    if (s->sparse && grad == 0) return;
    *mean = s->beta1 * *mean + (1 - s->beta1) * g;
    *square = s->beta2 * *square + (1 - s->beta2) * g * g;
    *x -= s->rate * *mean * s->correction1 / (sqrt(*square * s->correction2) + s->epsilon) + s->decay * *x;
}

FFP_FORMULA real ffp_adam_pulled(const FfpAdamStep *s, real x, real start) {
    return x - s->pull * (x - start);
}

FFP_FORMULA real ffp_adam_average(const FfpAdamStep *s, real average, real x) {
    return s->average * average + (1 - s->average) * x;
}

// Numbers with a step of their own, and what is kept of them.
typedef struct FfpAdamArray {
    FfpAdamStep step;
    int64_t count;
    real *x, *mean, *square; // mean and square begin at 0
    const real *grad;
    const real *start; // NULL: nothing pulls
    real *average;     // NULL: none is kept
} FfpAdamArray;

// One step of n arrays; on a thread that works on a device (core/base/device.h) they are the device's.
void ffp_adam(const FfpAdamArray *arrays, int n);

// Sum of squares, in double and a fixed order: the same bits for any number of threads.
double ffp_squared_norm(const real *x, int64_t count);

#endif
