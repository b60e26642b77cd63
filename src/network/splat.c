#include "network/splat.h"

#include <tgmath.h>

#define REACH 1.05F          // r: t_net may be anywhere within this of the ray's nearest point (network.md 6)
#define REACH_MARGIN 0.999F  // of r, where the start's distance lies on the sphere's edge or outside
#define CORRECTION_MAX 0.05F // of the matched distance
#define FLATNESS 0.1F        // third axis, the normal's, against the others (DESIGN 5)
#define START_WIDTH 0.425F   // of a footprint
#define LOG_SCALE_MIN (-4.0F) // residual form: x in [-4, ln 16]
#define LOG_SCALE_MAX 2.7725887F
#define PLAIN_LOG_SCALE_MIN (-8.0F)    // keeps exp off zero
#define PLAIN_LOG_SCALE_MAX 2.0794415F // ln 8
#define START_OPACITY 0.924F           // of a pixel that the object fills
#define OPACITY_MARGIN 1e-3F
#define PLAIN_OPACITY (-2.0F)
// The start's colours stay this far off 0 and 1, where a logit has no end. The ambient colour is seen, not
// inferred, and dark objects go below a hundredth; an albedo that low is a failed estimate, which the network
// must be able to lift.
#define ALBEDO_MARGIN 0.01F
#define AMBIENT_MARGIN 0.001F
#define ROUGHNESS_MIN 0.05F

static real sigmoid(real x) {
    return 1 / (1 + exp(-x));
}
static real sigmoid_slope(real x) {
    const real s = sigmoid(x);
    return s * (1 - s);
}

static real clamped(real x, real low, real high) {
    return fmin(fmax(x, low), high);
}

static real logit(real share, real margin) {
    const real c = clamped(share, margin, 1 - margin);
    return log(c / (1 - c));
}

void ffp_residual_base(FfpPixelBase *base, const FfpStart *start, int64_t pixel) {
    base->t = start->t[pixel];
    const real u = clamped((base->t - base->nearest) / REACH, -REACH_MARGIN, REACH_MARGIN);
    base->t_logit = log((1 + u) / (1 - u));
    base->footprint = start->footprint[pixel];
    base->opacity_logit = logit(START_OPACITY * start->coverage[pixel], OPACITY_MARGIN);
    ffp_normal_frame(start->normal + 3 * pixel, base->frame);
    for (int i = 0; i < 3; i++) {
        base->albedo_logit[i] = logit(start->albedo[3 * pixel + i], ALBEDO_MARGIN);
        base->ambient_logit[i] = logit(start->ambient[3 * pixel + i], AMBIENT_MARGIN);
    }
}

// width * exp(x), x limited. The gradient outside the limits is zero.
static void scale_forward(real out[3], const real x[3], real width, real third, real low, real high) {
    for (int i = 0; i < 3; i++) out[i] = width * (i == 2 ? third : 1) * exp(clamped(x[i], low, high));
}

static void scale_backward(real dx[3], const real dout[3], const real x[3], real width, real third, real low,
                           real high) {
    for (int i = 0; i < 3; i++)
        dx[i] = x[i] < low || x[i] > high ? 0 : dout[i] * width * (i == 2 ? third : 1) * exp(x[i]);
}

// normalise(x + (1,0,0,0)); returns 1 / length.
static real unit_quaternion(real out[4], const real x[4]) {
    const real w = x[0] + 1;
    const real inverse = 1 / sqrt(w * w + x[1] * x[1] + x[2] * x[2] + x[3] * x[3] + 1e-12F);
    out[0] = w * inverse;
    for (int i = 1; i < 4; i++) out[i] = x[i] * inverse;
    return inverse;
}

static void unit_quaternion_backward(real dx[4], const real dq[4], const real x[4]) {
    real q[4];
    const real inverse = unit_quaternion(q, x);
    const real along = dq[0] * q[0] + dq[1] * q[1] + dq[2] * q[2] + dq[3] * q[3];
    for (int i = 0; i < 4; i++) dx[i] = (dq[i] - along * q[i]) * inverse;
}

// out = f q (Hamilton product, w x y z)
static void quaternion_product(real out[4], const real f[4], const real q[4]) {
    out[0] = f[0] * q[0] - f[1] * q[1] - f[2] * q[2] - f[3] * q[3];
    out[1] = f[0] * q[1] + f[1] * q[0] + f[2] * q[3] - f[3] * q[2];
    out[2] = f[0] * q[2] - f[1] * q[3] + f[2] * q[0] + f[3] * q[1];
    out[3] = f[0] * q[3] + f[1] * q[2] - f[2] * q[1] + f[3] * q[0];
}

// The part of both forms' rows behind the scale: opacity, albedo 3, roughness, ambient 3.
static void appearance(FfpSplat *out, const real *x, real opacity, const real albedo[3],
                       const real ambient[3]) {
    out->opacity = sigmoid(x[0] + opacity);
    out->roughness = ROUGHNESS_MIN + (1 - ROUGHNESS_MIN) * sigmoid(x[4]);
    for (int i = 0; i < 3; i++) {
        out->albedo[i] = sigmoid(x[1 + i] + albedo[i]);
        out->ambient[i] = sigmoid(x[5 + i] + ambient[i]);
    }
}

static void appearance_backward(real *dx, const FfpSplat *grad, const real *x, real opacity,
                                const real albedo[3], const real ambient[3]) {
    dx[0] = grad->opacity * sigmoid_slope(x[0] + opacity);
    dx[4] = grad->roughness * (1 - ROUGHNESS_MIN) * sigmoid_slope(x[4]);
    for (int i = 0; i < 3; i++) {
        dx[1 + i] = grad->albedo[i] * sigmoid_slope(x[1 + i] + albedo[i]);
        dx[5 + i] = grad->ambient[i] * sigmoid_slope(x[5 + i] + ambient[i]);
    }
}

static const real zero[3] = {0, 0, 0};

void ffp_plain_splat(FfpSplat *out, const FfpPixelBase *base, const real *raw) {
    out->t = base->nearest + REACH * (2 * sigmoid(raw[0]) - 1);
    scale_forward(out->scale, raw + 1, base->footprint, 1, PLAIN_LOG_SCALE_MIN, PLAIN_LOG_SCALE_MAX);
    unit_quaternion(out->rotation, raw + 4);
    appearance(out, raw + 8, PLAIN_OPACITY, zero, zero);
}

void ffp_plain_splat_backward(real *draw, const FfpSplat *grad, const FfpPixelBase *base, const real *raw) {
    draw[0] = grad->t * REACH * 2 * sigmoid_slope(raw[0]);
    scale_backward(draw + 1, grad->scale, raw + 1, base->footprint, 1, PLAIN_LOG_SCALE_MIN,
                   PLAIN_LOG_SCALE_MAX);
    unit_quaternion_backward(draw + 4, grad->rotation, raw + 4);
    appearance_backward(draw + 8, grad, raw + 8, PLAIN_OPACITY, zero, zero);
}

// t = g t_match + (1 - g) t_net, both written as distances from the start, so that zeros give its bits:
//   t_match = t_0 + 0.05 tanh(correction),  t_net = t_0 + 2 r (sigmoid(x + x_0) - sigmoid(x_0))
// which is -o.d + r (2 sigmoid(x + x_0) - 1) when x_0 stands for t_0.
void ffp_residual_splat(FfpSplat *out, const FfpPixelBase *base, const real *raw) {
    const real gate = sigmoid(raw[1]);
    const real net = 2 * REACH * (sigmoid(raw[2] + base->t_logit) - sigmoid(base->t_logit));
    out->t = base->t + gate * CORRECTION_MAX * tanh(raw[0]) + (1 - gate) * net;
    scale_forward(out->scale, raw + 3, START_WIDTH * base->footprint, FLATNESS, LOG_SCALE_MIN, LOG_SCALE_MAX);
    real turn[4];
    unit_quaternion(turn, raw + 6);
    quaternion_product(out->rotation, base->frame, turn);
    appearance(out, raw + 10, base->opacity_logit, base->albedo_logit, base->ambient_logit);
}

void ffp_residual_splat_backward(real *draw, const FfpSplat *grad, const FfpPixelBase *base,
                                 const real *raw) {
    const real gate = sigmoid(raw[1]), bend = tanh(raw[0]);
    const real net = 2 * REACH * (sigmoid(raw[2] + base->t_logit) - sigmoid(base->t_logit));
    draw[0] = grad->t * gate * CORRECTION_MAX * (1 - bend * bend);
    draw[1] = grad->t * gate * (1 - gate) * (CORRECTION_MAX * bend - net);
    draw[2] = grad->t * (1 - gate) * 2 * REACH * sigmoid_slope(raw[2] + base->t_logit);
    scale_backward(draw + 3, grad->scale, raw + 3, START_WIDTH * base->footprint, FLATNESS, LOG_SCALE_MIN,
                   LOG_SCALE_MAX);
    const real inverse[4] = {base->frame[0], -base->frame[1], -base->frame[2], -base->frame[3]};
    real dturn[4]; // the product with a constant is linear; its adjoint is the product with the conjugate
    quaternion_product(dturn, inverse, grad->rotation);
    unit_quaternion_backward(draw + 6, dturn, raw + 6);
    appearance_backward(draw + 10, grad, raw + 10, base->opacity_logit, base->albedo_logit,
                        base->ambient_logit);
}
