// The heads' formulas: from a pixel's raw numbers to its Gaussian, around what is known of the pixel. Both
// forms forward and backward; no parameters live here. The GPU's kernels share them.
#ifndef FFP_NETWORK_SPLAT_FORMULA_H
#define FFP_NETWORK_SPLAT_FORMULA_H

#include <tgmath.h>
#include "core/base/real.h"
#include "core/gaussians/gaussians.h"

enum { FFP_PLAIN_NUMBERS = 16, FFP_RESIDUAL_NUMBERS = 18 };

// The values that the formulas start from.
typedef struct FfpPixelBase {
    real origin[3];             // the camera
    real direction[3], nearest; // the unit ray and -o.d, the distance to its point nearest to the origin
    real footprint; // world width of a pixel: at the nearest point (plain), at the start's point (residual)
    // Residual form only:
    real t, t_logit; // the start's distance, and where t_net's sigmoid stands for it
    real opacity_logit, frame[4], albedo_logit[3], ambient_logit[3];
} FfpPixelBase;

typedef struct FfpPixelSplat { // one Gaussian, or the gradient with respect to it
    real t, scale[3], rotation[4], opacity, albedo[3], roughness, ambient[3];
} FfpPixelSplat;

// r: t_net may be anywhere within this of the ray's nearest point to the origin. A sigmoid between two
// distances, as in GS-LRM (Zhang et al. 2024)
#define FFP_SPLAT_REACH 1.05F
#define FFP_SPLAT_REACH_MARGIN 0.999F // of r, where the start's distance lies on the sphere's edge or outside
#define FFP_SPLAT_CORRECTION_MAX 0.05F  // of the matched distance
#define FFP_SPLAT_FLATNESS 0.1F         // third axis, the normal's, against the others
#define FFP_SPLAT_INITIAL_WIDTH 0.425F  // of a footprint
#define FFP_SPLAT_LOG_SCALE_MIN (-4.0F) // residual form: x in [-4, ln 16]
#define FFP_SPLAT_LOG_SCALE_MAX 2.7725887F
#define FFP_SPLAT_PLAIN_LOG_SCALE_MIN (-8.0F)    // keeps exp off zero
#define FFP_SPLAT_PLAIN_LOG_SCALE_MAX 2.0794415F // ln 8
#define FFP_SPLAT_INITIAL_OPACITY 0.924F         // of a pixel that the object fills
#define FFP_SPLAT_OPACITY_MARGIN 1e-3F
#define FFP_SPLAT_PLAIN_OPACITY (-2.0F)
// The start's colours are kept this far from 0 and 1, where a logit is infinite. The ambient colour is seen,
// not inferred, and dark objects go below a hundredth; an albedo that low is a failed estimate, which the
// network must be able to raise.
#define FFP_SPLAT_ALBEDO_MARGIN 0.01F
#define FFP_SPLAT_AMBIENT_MARGIN 0.001F
#define FFP_SPLAT_ROUGHNESS_MIN 0.05F

FFP_FORMULA real ffp_splat_sigmoid(real x) {
    return 1 / (1 + exp(-x));
}
FFP_FORMULA real ffp_splat_sigmoid_slope(real x) {
    const real s = ffp_splat_sigmoid(x);
    return s * (1 - s);
}

FFP_FORMULA real ffp_splat_clamped(real x, real low, real high) {
    return fmin(fmax(x, low), high);
}

FFP_FORMULA real ffp_splat_logit(real share, real margin) {
    const real c = ffp_splat_clamped(share, margin, 1 - margin);
    return log(c / (1 - c));
}

// width * exp(x), x limited. The gradient outside the limits is zero.
FFP_FORMULA void ffp_splat_scale_forward(real out[3], const real x[3], real width, real third, real low,
                                         real high) {
    for (int i = 0; i < 3; i++)
        out[i] = width * (i == 2 ? third : 1) * exp(ffp_splat_clamped(x[i], low, high));
}

FFP_FORMULA void ffp_splat_scale_backward(real dx[3], const real dout[3], const real x[3], real width,
                                          real third, real low, real high) {
    for (int i = 0; i < 3; i++)
        dx[i] = x[i] < low || x[i] > high ? 0 : dout[i] * width * (i == 2 ? third : 1) * exp(x[i]);
}

// normalise(x + (1,0,0,0)); returns 1 / length.
FFP_FORMULA real ffp_splat_unit_quaternion(real out[4], const real x[4]) {
    const real w = x[0] + 1;
    const real inverse = 1 / sqrt(w * w + x[1] * x[1] + x[2] * x[2] + x[3] * x[3] + 1e-12F);
    out[0] = w * inverse;
    for (int i = 1; i < 4; i++) out[i] = x[i] * inverse;
    return inverse;
}

FFP_FORMULA void ffp_splat_unit_quaternion_backward(real dx[4], const real dq[4], const real x[4]) {
    real q[4];
    const real inverse = ffp_splat_unit_quaternion(q, x);
    const real along = dq[0] * q[0] + dq[1] * q[1] + dq[2] * q[2] + dq[3] * q[3];
    for (int i = 0; i < 4; i++) dx[i] = (dq[i] - along * q[i]) * inverse;
}

// out = f q (Hamilton product, w x y z)
FFP_FORMULA void ffp_splat_quaternion_product(real out[4], const real f[4], const real q[4]) {
    out[0] = f[0] * q[0] - f[1] * q[1] - f[2] * q[2] - f[3] * q[3];
    out[1] = f[0] * q[1] + f[1] * q[0] + f[2] * q[3] - f[3] * q[2];
    out[2] = f[0] * q[2] - f[1] * q[3] + f[2] * q[0] + f[3] * q[1];
    out[3] = f[0] * q[3] + f[1] * q[2] - f[2] * q[1] + f[3] * q[0];
}

// The part of both forms' rows behind the scale: opacity, albedo 3, roughness, ambient 3.
FFP_FORMULA void ffp_splat_appearance(FfpPixelSplat *out, const real *x, real opacity, const real albedo[3],
                                      const real ambient[3]) {
    out->opacity = ffp_splat_sigmoid(x[0] + opacity);
    out->roughness = FFP_SPLAT_ROUGHNESS_MIN + (1 - FFP_SPLAT_ROUGHNESS_MIN) * ffp_splat_sigmoid(x[4]);
    for (int i = 0; i < 3; i++) {
        out->albedo[i] = ffp_splat_sigmoid(x[1 + i] + albedo[i]);
        out->ambient[i] = ffp_splat_sigmoid(x[5 + i] + ambient[i]);
    }
}

FFP_FORMULA void ffp_splat_appearance_backward(real *dx, const FfpPixelSplat *grad, const real *x,
                                               real opacity, const real albedo[3], const real ambient[3]) {
    dx[0] = grad->opacity * ffp_splat_sigmoid_slope(x[0] + opacity);
    dx[4] = grad->roughness * (1 - FFP_SPLAT_ROUGHNESS_MIN) * ffp_splat_sigmoid_slope(x[4]);
    for (int i = 0; i < 3; i++) {
        dx[1 + i] = grad->albedo[i] * ffp_splat_sigmoid_slope(x[1 + i] + albedo[i]);
        dx[5 + i] = grad->ambient[i] * ffp_splat_sigmoid_slope(x[5 + i] + ambient[i]);
    }
}

// raw [16]: t, scale 3, quaternion 4, opacity, albedo 3, roughness, ambient 3
FFP_FORMULA void ffp_plain_splat(FfpPixelSplat *out, const FfpPixelBase *base, const real *raw) {
    out->t = base->nearest + FFP_SPLAT_REACH * (2 * ffp_splat_sigmoid(raw[0]) - 1);
    ffp_splat_scale_forward(out->scale, raw + 1, base->footprint, 1, FFP_SPLAT_PLAIN_LOG_SCALE_MIN,
                            FFP_SPLAT_PLAIN_LOG_SCALE_MAX);
    ffp_splat_unit_quaternion(out->rotation, raw + 4);
    const real zero[3] = {0, 0, 0};
    ffp_splat_appearance(out, raw + 8, FFP_SPLAT_PLAIN_OPACITY, zero, zero);
}

FFP_FORMULA void ffp_plain_splat_backward(real *draw, const FfpPixelSplat *grad, const FfpPixelBase *base,
                                          const real *raw) {
    draw[0] = grad->t * FFP_SPLAT_REACH * 2 * ffp_splat_sigmoid_slope(raw[0]);
    ffp_splat_scale_backward(draw + 1, grad->scale, raw + 1, base->footprint, 1,
                             FFP_SPLAT_PLAIN_LOG_SCALE_MIN, FFP_SPLAT_PLAIN_LOG_SCALE_MAX);
    ffp_splat_unit_quaternion_backward(draw + 4, grad->rotation, raw + 4);
    const real zero[3] = {0, 0, 0};
    ffp_splat_appearance_backward(draw + 8, grad, raw + 8, FFP_SPLAT_PLAIN_OPACITY, zero, zero);
}

// raw [18]: correction, gate, t_net, then as above from the scale on. All zero: the classical initialisation.
// t = g t_match + (1 - g) t_net, both written as distances from the start, so that zeros give its bits:
//   t_match = t_0 + 0.05 tanh(correction),  t_net = t_0 + 2 r (ffp_splat_sigmoid(x + x_0) -
//   ffp_splat_sigmoid(x_0))
// which is -o.d + r (2 ffp_splat_sigmoid(x + x_0) - 1) when x_0 stands for t_0.
FFP_FORMULA void ffp_residual_splat(FfpPixelSplat *out, const FfpPixelBase *base, const real *raw) {
    const real gate = ffp_splat_sigmoid(raw[1]);
    const real net =
        2 * FFP_SPLAT_REACH * (ffp_splat_sigmoid(raw[2] + base->t_logit) - ffp_splat_sigmoid(base->t_logit));
    out->t = base->t + gate * FFP_SPLAT_CORRECTION_MAX * tanh(raw[0]) + (1 - gate) * net;
    ffp_splat_scale_forward(out->scale, raw + 3, FFP_SPLAT_INITIAL_WIDTH * base->footprint,
                            FFP_SPLAT_FLATNESS, FFP_SPLAT_LOG_SCALE_MIN, FFP_SPLAT_LOG_SCALE_MAX);
    real turn[4];
    ffp_splat_unit_quaternion(turn, raw + 6);
    ffp_splat_quaternion_product(out->rotation, base->frame, turn);
    ffp_splat_appearance(out, raw + 10, base->opacity_logit, base->albedo_logit, base->ambient_logit);
}

FFP_FORMULA void ffp_residual_splat_backward(real *draw, const FfpPixelSplat *grad, const FfpPixelBase *base,
                                             const real *raw) {
    const real gate = ffp_splat_sigmoid(raw[1]), bend = tanh(raw[0]);
    const real net =
        2 * FFP_SPLAT_REACH * (ffp_splat_sigmoid(raw[2] + base->t_logit) - ffp_splat_sigmoid(base->t_logit));
    draw[0] = grad->t * gate * FFP_SPLAT_CORRECTION_MAX * (1 - bend * bend);
    draw[1] = grad->t * gate * (1 - gate) * (FFP_SPLAT_CORRECTION_MAX * bend - net);
    draw[2] = grad->t * (1 - gate) * 2 * FFP_SPLAT_REACH * ffp_splat_sigmoid_slope(raw[2] + base->t_logit);
    ffp_splat_scale_backward(draw + 3, grad->scale, raw + 3, FFP_SPLAT_INITIAL_WIDTH * base->footprint,
                             FFP_SPLAT_FLATNESS, FFP_SPLAT_LOG_SCALE_MIN, FFP_SPLAT_LOG_SCALE_MAX);
    const real inverse[4] = {base->frame[0], -base->frame[1], -base->frame[2], -base->frame[3]};
    real dturn[4]; // the product with a constant is linear; its adjoint is the product with the conjugate
    ffp_splat_quaternion_product(dturn, inverse, grad->rotation);
    ffp_splat_unit_quaternion_backward(draw + 6, dturn, raw + 6);
    ffp_splat_appearance_backward(draw + 10, grad, raw + 10, base->opacity_logit, base->albedo_logit,
                                  base->ambient_logit);
}

// Gaussian g of the set is the splat of that pixel.
FFP_FORMULA void ffp_splat_store(const FfpGaussians *out, int64_t g, const FfpPixelSplat *splat,
                                 const FfpPixelBase *base) {
    for (int i = 0; i < 3; i++) {
        out->centre[3 * g + i] = base->origin[i] + splat->t * base->direction[i];
        out->scale[3 * g + i] = splat->scale[i];
        out->albedo[3 * g + i] = splat->albedo[i];
        out->ambient[3 * g + i] = splat->ambient[i];
    }
    for (int i = 0; i < 4; i++) out->rotation[4 * g + i] = splat->rotation[i];
    out->opacity[g] = splat->opacity;
    out->roughness[g] = splat->roughness;
}

#endif
