// Exponentials that gcc vectorises: libm's expf is a call per
// element. The double build (gradient tests) uses libm.
#ifndef FFP_TENSOR_FASTMATH_H
#define FFP_TENSOR_FASTMATH_H

#include <math.h>
#include <stdint.h>
#include "base/real.h"

// e^x = 2^n e^r with |r| <= ln 2 / 2 and e^r by its Taylor sum up to r^7 (remainder below 6e-9). Relative
// error below 2e-7 on [-87, 88]; saturates outside (1.6e-38, 1.7e38); NaN stays NaN.
static inline float ffp_exp_f32(float x) {
    x = x < -87.0F ? -87.0F : x;
    x = x > 88.0F ? 88.0F : x;
    const float magic =
        12582912.0F; // 1.5 * 2^23: behind the sum the low mantissa bits hold n = round(x / ln 2)
    const float shifted = x * 1.44269504F + magic, n = shifted - magic;
    const float r =
        (x - n * 0.693359375F) + n * 2.12194440e-4F; // ln 2 in two parts, the first exact in 9 bits
    float p = 1.0F / 5040.0F;
    p = p * r + 1.0F / 720.0F;
    p = p * r + 1.0F / 120.0F;
    p = p * r + 1.0F / 24.0F;
    p = p * r + 1.0F / 6.0F;
    p = p * r + 0.5F;
    p = p * r + 1.0F;
    p = p * r + 1.0F;
    union {
        float number;
        uint32_t bits;
    } scale = {.number = shifted};
    scale.bits = (scale.bits << 23) + 0x3F800000U; // 2^n: everything but n leaves at the top
    return p * scale.number;
}

static inline real ffp_exp(real x) {
    return _Generic(x, float : ffp_exp_f32, double : exp)(x);
}

static inline real ffp_sigmoid(real x) {
    return 1.0F / (1.0F + ffp_exp(-x));
}

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
