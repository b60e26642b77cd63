// Numbers into attributes and gradients back (engine/refine/maps.h), attribute by attribute: loops that gcc
// vectorises; and the table of one CPU level.
#include "engine/refine/kernels/kernels.h"
#include "engine/refine/maps.h"

static void sigmoids(const real *restrict number, real *restrict out, int64_t count) {
    for (int64_t i = 0; i < count; i++) out[i] = ffp_number_sigmoid(number[i]);
}

static void sigmoids_backward(const real *restrict out, real *restrict grad, int64_t count) {
    for (int64_t i = 0; i < count; i++) grad[i] *= ffp_number_sigmoid_slope(out[i]);
}

void FFP_K(decode)(const FfpParameters *p, int64_t begin, int64_t count, const FfpGaussians *out) {
    const FfpGaussians *n = &p->numbers;
    const int64_t colours = 3 * begin;
    const real *restrict log_scale = n->scale + colours, *restrict rough = n->roughness + begin;
    real *restrict scale = out->scale + colours, *restrict roughness = out->roughness + begin;
    for (int64_t i = 0; i < 3 * count; i++) scale[i] = ffp_exp(log_scale[i]);
    for (int64_t i = 0; i < count; i++) roughness[i] = ffp_roughness_of(rough[i]);
    sigmoids(n->albedo + colours, out->albedo + colours, 3 * count);
    sigmoids(n->ambient + colours, out->ambient + colours, 3 * count);
    sigmoids(n->opacity + begin, out->opacity + begin, count);
    for (int64_t i = begin; i < begin + count; i++) ffp_decode_frame(p, i, out);
}

void FFP_K(pull_back)(const FfpParameters *p, const FfpGaussians *decoded, int64_t begin, int64_t count,
                      const FfpGaussians *grad) {
    const int64_t colours = 3 * begin;
    const real *restrict scale = decoded->scale + colours, *restrict roughness = decoded->roughness + begin;
    real *restrict d_scale = grad->scale + colours, *restrict d_roughness = grad->roughness + begin;
    for (int64_t i = 0; i < 3 * count; i++) d_scale[i] *= scale[i];
    for (int64_t i = 0; i < count; i++) d_roughness[i] *= ffp_roughness_slope(roughness[i]);
    sigmoids_backward(decoded->albedo + colours, grad->albedo + colours, 3 * count);
    sigmoids_backward(decoded->ambient + colours, grad->ambient + colours, 3 * count);
    sigmoids_backward(decoded->opacity + begin, grad->opacity + begin, count);
    for (int64_t i = begin; i < begin + count; i++) ffp_pull_back_frame(p, decoded, i, grad);
}

const FfpRefineKernels FFP_K(refine) = {.decode = FFP_K(decode), .pull_back = FFP_K(pull_back)};
