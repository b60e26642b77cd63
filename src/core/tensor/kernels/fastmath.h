// Functions made of exponentials that gcc vectorises (core/base/exp2.h). The double build (gradient tests)
// uses libm.
#ifndef FFP_TENSOR_FASTMATH_H
#define FFP_TENSOR_FASTMATH_H

#include <math.h>
#include "core/base/exp2.h"

// Standard normal distribution Phi(x), and its density in *density. erfc by
// Abramowitz & Stegun 7.1.26: with the rounding of fp32 the absolute error stays
// below 3e-7. The small tail is computed as such, so that nothing cancels for x < 0.
static inline float ffp_normal_f32(float x, float *density) {
    const float e = ffp_exp_f32(-0.5F * x * x);
    const float t = 1.0F / (1.0F + 0.3275911F * 0.707106781F * fabsf(x));
    float p = 1.061405429F;
    p = p * t - 1.453152027F;
    p = p * t + 1.421413741F;
    p = p * t - 0.284496736F;
    p = p * t + 0.254829592F;
    const float tail = 0.5F * p * t * e;
    *density = 0.398942280F * e;
    return x < 0 ? tail : 1.0F - tail;
}

static inline double ffp_normal_f64(double x, double *density) {
    *density = exp(-0.5 * x * x) / sqrt(2.0 * FFP_PI_DOUBLE);
    return 0.5 * erfc(-x * 0.70710678118654752440);
}

static inline real ffp_normal(real x, real *density) {
    return _Generic(x, float : ffp_normal_f32, double : ffp_normal_f64)(x, density);
}

#endif
