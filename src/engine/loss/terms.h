// The terms of loss.h at one pixel (or value), as CPU and GPU both take them. Private to this room and its
// kernels.
#ifndef FFP_LOSS_TERMS_H
#define FFP_LOSS_TERMS_H

#include <stdbool.h>
#include <tgmath.h>
#include "core/base/real.h"
#include "core/base/vec.h"

// Below this opacity (or length of a summed normal) a pixel carries no surface to compare: 1/O would only
// amplify noise.
#define FFP_LEAST_COVER 0.1F

// `size` with the sign of x; 0 at 0.
FFP_FORMULA real ffp_signed(real size, real x) {
    return x > 0 ? size : x < 0 ? -size : 0;
}

FFP_FORMULA real ffp_held_opacity(real opacity) {
    const real low = 1e-6F, high = 1 - 1e-6F;
    return fmin(fmax(opacity, low), high);
}

// Minus the cross-entropy.
FFP_FORMULA real ffp_mask_term(real opacity, real mask) {
    const real o = ffp_held_opacity(opacity);
    return mask * log(o) + (1 - mask) * log(1 - o);
}

// scale * the cross-entropy's derivative by opacity: 0 where that was held.
FFP_FORMULA real ffp_mask_slope(real opacity, real mask, real scale) {
    const real o = ffp_held_opacity(opacity);
    return o == opacity ? scale * (o - mask) / (o * (1 - o)) : 0;
}

FFP_FORMULA bool ffp_depth_counts(real opacity, real truth) {
    return truth > 0 && opacity > 0.5F;
}

FFP_FORMULA real ffp_depth_term(real depth_sum, real opacity, real truth) {
    const real error = depth_sum / opacity - truth;
    return error * error;
}

// scale / 2 * the derivatives: returns that by depth_sum, *by_opacity gets minus the other.
FFP_FORMULA real ffp_depth_slope(real depth_sum, real opacity, real truth, real scale, real *by_opacity) {
    const real depth = depth_sum / opacity, slope = scale * (depth - truth) / opacity;
    *by_opacity = slope * depth;
    return slope;
}

// The unit normal of a sum and the sum's length; true if it counts: foreground with a normal to speak of.
FFP_FORMULA bool ffp_unit_normal(real unit[3], real *length, const real sum[3], real mask) {
    for (int c = 0; c < 3; c++) unit[c] = sum[c];
    *length = ffp_normalise3(unit);
    return mask > 0.5F && *length > FFP_LEAST_COVER;
}

// Adds scale * (I - u u^T) slope to grad: from the unit normal u to the sum, by whose length `scale` is
// divided.
FFP_FORMULA void ffp_unit_normal_backward(real grad[3], const real slope[3], const real unit[3], real scale) {
    const real along = ffp_dot3(slope, unit);
    for (int c = 0; c < 3; c++) grad[c] += scale * (slope[c] - along * unit[c]);
}

FFP_FORMULA bool ffp_roughness_counts(real opacity, real mask) {
    return mask > 0.5F && opacity > FFP_LEAST_COVER;
}

// From pixel i to its neighbour j: the step in roughness, and *trust, how much the albedos let it count.
FFP_FORMULA real ffp_roughness_step(const real *roughness_sum, const real *albedo_sum, const real *opacity,
                                    int i, int j, real *trust) {
    real change = 0;
    for (int c = 0; c < 3; c++)
        change += fabs(albedo_sum[3 * j + c] / opacity[j] - albedo_sum[3 * i + c] / opacity[i]);
    *trust = exp(-change);
    return roughness_sum[j] / opacity[j] - roughness_sum[i] / opacity[i];
}

// The structural similarity of one pixel from its moments, sigma_a^2 = E[aa] - E[a]^2 and so on:
// (2 mu_a mu_b + C1) (2 sigma_ab + C2) / ((mu_a^2 + mu_b^2 + C1) (sigma_a^2 + sigma_b^2 + C2)), and its
// derivatives by E[a], E[aa], E[ab].
FFP_FORMULA real ffp_ssim_term(real a, real b, real aa, real bb, real ab, real *slope_a, real *slope_aa,
                               real *slope_ab) {
    const real c1 = 1e-4F, c2 = 9e-4F;
    const real product = a * b, squares = a * a + b * b;
    const real top1 = 2 * product + c1, top2 = 2 * (ab - product) + c2;
    const real bottom1 = squares + c1, bottom2 = aa + bb - squares + c2;
    const real inverse = 1 / (bottom1 * bottom2), index = top1 * top2 * inverse;
    *slope_a = 2 * b * (top2 - top1) * inverse + 2 * a * index * (1 / bottom2 - 1 / bottom1);
    *slope_aa = -index / bottom2;
    *slope_ab = 2 * top1 * inverse;
    return index;
}

// LPIPS: the derivative of sum_c head_c (u_c - v_c)^2, u = a/|a|, by one a_c; difference = u_c - v_c, along =
// sum_c 2 head_c (u_c - v_c) u_c, inverse = 1/|a|. A zero vector has shut ReLUs and gets none.
FFP_FORMULA real ffp_lpips_slope(real a, real u, real difference, real head, real along, real inverse) {
    return a > 0 ? (2 * head * difference - along * u) * inverse : 0;
}

#endif
