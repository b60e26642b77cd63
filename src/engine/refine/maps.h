// One splat's numbers (parameters.h) from its attributes, the way back, and the gradient's way through:
// formulas that the CPU and the GPU share. Arrays are those of whole sets, i the splat.
#ifndef FFP_REFINE_MAPS_H
#define FFP_REFINE_MAPS_H

#include "core/base/exp2.h"
#include "core/base/vec.h"
#include "engine/refine/parameters.h"

#define FFP_SIGMOID_LEAST 1e-4F    // sigmoids start this far from their ends at least
#define FFP_ROUGHNESS_FLOOR 0.05F  // as the network's heads have it
#define FFP_FLATNESS 0.05F         // of a flat set: third deviation over the smaller of the others
#define FFP_DEVIATION_LEAST 1e-12F // has a logarithm

FFP_FORMULA real ffp_number_sigmoid(real x) {
    return 1 / (1 + ffp_exp(-x));
}

FFP_FORMULA real ffp_logit(real p) {
    const real inside = fmin(fmax(p, FFP_SIGMOID_LEAST), 1 - FFP_SIGMOID_LEAST);
    return log(inside / (1 - inside));
}

FFP_FORMULA real ffp_length4(const real q[4]) {
    return sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
}

FFP_FORMULA void ffp_unit_quaternion(const real q[4], real out[4]) {
    const real length = ffp_length4(q);
    for (int k = 0; k < 4; k++) out[k] = length > 0 ? q[k] / length : k == 0;
}

// All of p's arrays at i; local as in ffp_parameters_new.
FFP_FORMULA void ffp_encode(const FfpGaussians *g, int64_t i, bool local, const FfpParameters *p) {
    const FfpGaussians *n = &p->numbers;
    ffp_unit_quaternion(g->rotation + 4 * i, n->rotation + 4 * i);
    for (int k = 0; k < 4; k++) p->frame[4 * i + k] = local ? n->rotation[4 * i + k] : k == 0;
    for (int k = 0; k < 3; k++) {
        const int64_t at = 3 * i + k;
        p->origin[at] = local ? g->centre[at] : 0;
        n->centre[at] = local ? 0 : g->centre[at];
        n->scale[at] = log(fmax(g->scale[at], FFP_DEVIATION_LEAST));
        n->albedo[at] = ffp_logit(g->albedo[at]);
        n->ambient[at] = ffp_logit(g->ambient[at]);
        n->scattered[at] = g->scatters ? sqrt(g->scattered[at]) : 0;
    }
    n->opacity[i] = ffp_logit(g->opacity[i]);
    n->roughness[i] = ffp_logit((g->roughness[i] - FFP_ROUGHNESS_FLOOR) / (1 - FFP_ROUGHNESS_FLOOR));
    p->unit[i] = local ? fmax(fmax(g->scale[3 * i], g->scale[3 * i + 1]), g->scale[3 * i + 2]) : 1;
}

FFP_FORMULA real ffp_roughness_of(real number) {
    return FFP_ROUGHNESS_FLOOR + (1 - FFP_ROUGHNESS_FLOOR) * ffp_number_sigmoid(number);
}

// By the numbers' frame: centre and rotation; and the third deviation of a flat set, from the others.
FFP_FORMULA void ffp_decode_frame(const FfpParameters *p, int64_t i, const FfpGaussians *out) {
    const FfpGaussians *n = &p->numbers;
    real m[9];
    ffp_quaternion_matrix(p->frame + 4 * i, m);
    for (int k = 0; k < 3; k++)
        out->centre[3 * i + k] = p->origin[3 * i + k] + p->unit[i] * ffp_dot3(m + 3 * k, n->centre + 3 * i);
    if (p->flat) out->scale[3 * i + 2] = FFP_FLATNESS * fmin(out->scale[3 * i], out->scale[3 * i + 1]);
    ffp_unit_quaternion(n->rotation + 4 * i, out->rotation + 4 * i);
}

FFP_FORMULA real ffp_deviation_of(real number, real most) {
    return fmin(ffp_exp(number), most);
}

FFP_FORMULA void ffp_decode(const FfpParameters *p, int64_t i, const FfpGaussians *out) {
    const FfpGaussians *n = &p->numbers;
    for (int k = 0; k < 3; k++) {
        const int64_t at = 3 * i + k;
        out->scale[at] = ffp_deviation_of(n->scale[at], p->most * p->unit[i]);
        out->albedo[at] = ffp_number_sigmoid(n->albedo[at]);
        out->ambient[at] = ffp_number_sigmoid(n->ambient[at]);
        out->scattered[at] = n->scattered[at] * n->scattered[at];
    }
    out->opacity[i] = ffp_number_sigmoid(n->opacity[i]);
    out->roughness[i] = ffp_roughness_of(n->roughness[i]);
    ffp_decode_frame(p, i, out);
}

// g / |q| less its part along q / |q|: through the normalisation.
FFP_FORMULA void ffp_pull_back_rotation(const real *number, const real *unit, real *grad) {
    const real length = ffp_length4(number);
    real along = 0;
    for (int k = 0; k < 4; k++) along += grad[k] * unit[k];
    for (int k = 0; k < 4; k++) grad[k] = length > 0 ? (grad[k] - along * unit[k]) / length : 0;
}

// sigmoid' from the sigmoid.
FFP_FORMULA real ffp_number_sigmoid_slope(real s) {
    return s * (1 - s);
}

FFP_FORMULA real ffp_roughness_slope(real roughness) {
    return (1 - FFP_ROUGHNESS_FLOOR) *
           ffp_number_sigmoid_slope((roughness - FFP_ROUGHNESS_FLOOR) / (1 - FFP_ROUGHNESS_FLOOR));
}

// Pulls back the gradient of ffp_decode_frame's result, in place; d is the result of ffp_decode.
FFP_FORMULA void ffp_pull_back_frame(const FfpParameters *p, const FfpGaussians *d, int64_t i,
                                     const FfpGaussians *grad) {
    real m[9], world[3];
    ffp_quaternion_matrix(p->frame + 4 * i, m);
    for (int k = 0; k < 3; k++) world[k] = grad->centre[3 * i + k];
    for (int k = 0; k < 3; k++)
        grad->centre[3 * i + k] = p->unit[i] * (m[k] * world[0] + m[3 + k] * world[1] + m[6 + k] * world[2]);
    if (p->flat) grad->scale[3 * i + 2] = 0;
    ffp_pull_back_rotation(p->numbers.rotation + 4 * i, d->rotation + 4 * i, grad->rotation + 4 * i);
}

FFP_FORMULA void ffp_pull_back(const FfpParameters *p, const FfpGaussians *d, int64_t i,
                               const FfpGaussians *grad) {
    for (int k = 0; k < 3; k++) {
        const int64_t at = 3 * i + k;
        grad->scale[at] *= d->scale[at];
        grad->albedo[at] *= ffp_number_sigmoid_slope(d->albedo[at]);
        grad->ambient[at] *= ffp_number_sigmoid_slope(d->ambient[at]);
        grad->scattered[at] *= 2 * p->numbers.scattered[at];
    }
    grad->opacity[i] *= ffp_number_sigmoid_slope(d->opacity[i]);
    grad->roughness[i] *= ffp_roughness_slope(d->roughness[i]);
    ffp_pull_back_frame(p, d, i, grad);
}

// A number's mean over n steps, from that over n - 1: share = 1 / n.
FFP_FORMULA void ffp_average(real number, real share, real *mean) {
    *mean += share * (number - *mean);
}

#endif
