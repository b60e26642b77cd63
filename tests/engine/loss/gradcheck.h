// Analytic gradients against central differences, for this room's double tests.
#ifndef FFP_TESTS_LOSS_GRADCHECK_H
#define FFP_TESTS_LOSS_GRADCHECK_H

#include <math.h>
#include "core/base/arena.h"
#include "core/base/real.h"
#include "core/base/rng.h"
#include "support.h"

#define GRAD_START 0.25 // what gradients hold before: a loss must add to it

static inline real *random_values(size_t count, uint64_t seed, float low, float high) {
    FfpRng rng = ffp_rng(seed, 0);
    real *values = ffp_alloc(count, sizeof *values);
    for (size_t i = 0; i < count; i++) values[i] = ffp_rng_range(&rng, low, high);
    return values;
}

static inline real *new_gradient(size_t count) {
    real *grad = ffp_alloc(count, sizeof *grad);
    for (size_t i = 0; i < count; i++) grad[i] = GRAD_START;
    return grad;
}

// Every `every`-th of the `count` values x that f depends on: (f(x+h) - f(x-h)) / 2h against grad -
// GRAD_START, within tolerance times the largest gradient, which must not be zero.
static inline void check_gradient(const char *what, double (*f)(void *), void *context, real *x,
                                  const real *grad, int count, int every, double h, double tolerance) {
    double largest = 0;
    for (int i = 0; i < count; i++) largest = worse(largest, fabs(grad[i] - GRAD_START));
    if (!(largest > 0)) fail_msg("%s: no gradient at all", what);
    for (int i = 0; i < count; i += every) {
        const real kept = x[i];
        x[i] = kept + h;
        const double above = f(context);
        x[i] = kept - h;
        const double below = f(context);
        x[i] = kept;
        const double numeric = (above - below) / (2 * h), analytic = grad[i] - GRAD_START;
        if (!(fabs(numeric - analytic) <= tolerance * largest))
            fail_msg("%s[%d]: analytic %.10g, numeric %.10g", what, i, analytic, numeric);
    }
}

#endif
