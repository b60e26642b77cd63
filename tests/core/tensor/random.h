// Random arrays for the tensor tests.
#ifndef FFP_TESTS_TENSOR_RANDOM_H
#define FFP_TESTS_TENSOR_RANDOM_H

#include "core/base/arena.h"
#include "core/base/real.h"
#include "core/base/rng.h"

// count random normal numbers times scale plus shift; release with ffp_free()
static inline real *random_reals(FfpRng *rng, size_t count, double scale, double shift) {
    real *values = ffp_alloc(count, sizeof(real));
    for (size_t i = 0; i < count; i++) values[i] = (real)(scale * (double)ffp_rng_normal(rng) + shift);
    return values;
}

#endif
