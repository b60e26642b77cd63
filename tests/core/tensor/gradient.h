// Gradient checks for the double build: a kernel's backward
// against central differences of sum(weights * output).
#ifndef FFP_TESTS_TENSOR_GRADIENT_H
#define FFP_TESTS_TENSOR_GRADIENT_H

#include <math.h>
#include "core/tensor/random.h"
#include "support.h"

static inline double dot_reals(const real *a, const real *b, size_t count) {
    double sum = 0;
    for (size_t i = 0; i < count; i++) sum += (double)a[i] * (double)b[i];
    return sum;
}

// Compares analytic[count] - before (what was there before the kernel added
// to it) with the derivative of loss(context) by each of values[count], which
// lie `stride` apart by rows of `width` (dense: width = stride = count).
static inline void check_gradient(const char *name, double (*loss)(void *), void *context, real *values,
                                  const real *analytic, double before, size_t rows, size_t width,
                                  size_t stride) {
    const double step = 1e-5;
    double worst = 0, largest = 0;
    for (size_t row = 0; row < rows; row++) {
        for (size_t i = 0; i < width; i++) {
            real *value = values + row * stride + i;
            const real kept = *value;
            *value = (real)((double)kept + step);
            const double above = loss(context);
            *value = (real)((double)kept - step);
            const double below = loss(context);
            *value = kept;
            const double expected = (above - below) / (2 * step);
            const double found = (double)analytic[row * stride + i] - before;
            worst = worse(worst, fabs(found - expected));
            largest = worse(largest, fabs(expected));
        }
    }
    printf("%-28s largest %.3g, worst error %.2g\n", name, largest, worst);
    assert_true(largest > 1e-6); // a gradient that is zero everywhere would prove nothing
    assert_true(worst < 1e-7 * (1 + largest));
}

#endif
