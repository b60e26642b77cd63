#include "engine/pipeline/maps.h"
#include <tgmath.h>

const char *ffp_map_name(FfpMap map) {
    static const char *const names[FFP_MAP_COUNT] = {"opacity",   "depth",   "normal",    "albedo",
                                                     "roughness", "ambient", "distortion"};
    return names[map];
}

FfpImage ffp_map_depth(const FfpGbuffer *gbuffer) {
    FfpImage depth = ffp_image_new(gbuffer->width, gbuffer->height, 1);
    const int pixels = gbuffer->width * gbuffer->height;
    for (int i = 0; i < pixels; i++)
        if (gbuffer->opacity[i] >= 0.5F) depth.data[i] = gbuffer->depth[i] / gbuffer->opacity[i];
    return depth;
}

static FfpImage depth_picture(const FfpGbuffer *gbuffer) {
    FfpImage depth = ffp_map_depth(gbuffer);
    const int pixels = depth.width * depth.height;
    real near = INFINITY, far = 0;
    for (int i = 0; i < pixels; i++)
        if (depth.data[i] > 0) {
            near = fmin(near, depth.data[i]);
            far = fmax(far, depth.data[i]);
        }
    const real range = far > near ? far - near : 1;
    for (int i = 0; i < pixels; i++)
        if (depth.data[i] > 0) depth.data[i] = 1 - 0.9F * (depth.data[i] - near) / range;
    return depth;
}

// The normal is the direction of the sum, shown where there is something to show.
static FfpImage normal_picture(const FfpGbuffer *gbuffer) {
    FfpImage picture = ffp_image_new(gbuffer->width, gbuffer->height, 3);
    const int pixels = gbuffer->width * gbuffer->height;
    for (int i = 0; i < pixels; i++) {
        const real *n = gbuffer->normal + 3 * (size_t)i;
        const real length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        if (length <= 0) continue;
        for (int c = 0; c < 3; c++)
            picture.data[3 * (size_t)i + c] = fmin(gbuffer->opacity[i], 1) * (0.5F + 0.5F * n[c] / length);
    }
    return picture;
}

// Raw sums are the attribute over black, which is what a picture of it should show.
static FfpImage sum_picture(const FfpGbuffer *gbuffer, const real *sum, int channels, bool encode) {
    FfpImage picture = ffp_image_new(gbuffer->width, gbuffer->height, channels);
    const size_t count = (size_t)gbuffer->width * gbuffer->height * channels;
    for (size_t i = 0; i < count; i++) picture.data[i] = encode ? ffp_srgb_encode(sum[i]) : sum[i];
    return picture;
}

FfpImage ffp_map_picture(const FfpGbuffer *gbuffer, FfpMap map) {
    switch (map) {
    case FFP_MAP_DEPTH:
        return depth_picture(gbuffer);
    case FFP_MAP_NORMAL:
        return normal_picture(gbuffer);
    case FFP_MAP_ALBEDO:
        return sum_picture(gbuffer, gbuffer->albedo, 3, true);
    case FFP_MAP_ROUGHNESS:
        return sum_picture(gbuffer, gbuffer->roughness, 1, false);
    case FFP_MAP_AMBIENT:
        return sum_picture(gbuffer, gbuffer->ambient, 3, true);
    default:
        return sum_picture(gbuffer, gbuffer->opacity, 1, false);
    }
}

int ffp_map_width(FfpMap map) {
    return map == FFP_MAP_NORMAL || map == FFP_MAP_ALBEDO || map == FFP_MAP_AMBIENT ? 3 : 1;
}

// Raw sums become means over what covers the pixel; opacity, ambient light and distortion are sums as they
// stand.
static void put_values(float *out, const FfpGbuffer *g, FfpMap map, size_t i) {
    const float opacity = g->opacity[i], share = opacity > 1e-3F ? 1 / opacity : 0;
    const float *n = g->normal + 3 * i;
    const float length = sqrtf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (size_t c = 0; c < 3; c++) {
        if (map == FFP_MAP_NORMAL) out[3 * i + c] = length > 1e-3F ? n[c] / length : 0;
        if (map == FFP_MAP_ALBEDO) out[3 * i + c] = g->albedo[3 * i + c] * share;
        if (map == FFP_MAP_AMBIENT) out[3 * i + c] = g->ambient[3 * i + c];
    }
    if (map == FFP_MAP_OPACITY) out[i] = opacity;
    if (map == FFP_MAP_DEPTH) out[i] = opacity >= 0.5F ? g->depth[i] * share : 0;
    if (map == FFP_MAP_ROUGHNESS) out[i] = g->roughness[i] * share;
    if (map == FFP_MAP_DISTORTION) out[i] = g->distortion[i];
}

void ffp_map_values(const FfpGbuffer *gbuffer, FfpMap map, float *out) {
    const size_t pixels = (size_t)gbuffer->width * (size_t)gbuffer->height;
    for (size_t i = 0; i < pixels; i++) put_values(out, gbuffer, map, i);
}

// A mean's gradient: to its sum, and to the opacity.
static void mean_backward(float grad, float sum, float share, float *to_sum, float *to_opacity) {
    *to_sum += grad * share;
    *to_opacity -= grad * sum * share * share;
}

static void normal_backward(const float *n, const float *grad, float *to) {
    const float length = sqrtf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    if (!(length > 1e-3F)) return;
    const float along = (grad[0] * n[0] + grad[1] * n[1] + grad[2] * n[2]) / (length * length);
    for (int c = 0; c < 3; c++) to[c] += (grad[c] - along * n[c]) / length;
}

static void values_backward(const FfpGbuffer *g, FfpMap map, size_t i, const float *grad, FfpGbuffer *to) {
    const float opacity = g->opacity[i], share = opacity > 1e-3F ? 1 / opacity : 0;
    float *to_opacity = &to->opacity[i];
    if (map == FFP_MAP_OPACITY) *to_opacity += grad[i];
    if (map == FFP_MAP_DISTORTION) to->distortion[i] += grad[i];
    if (map == FFP_MAP_DEPTH && opacity >= 0.5F)
        mean_backward(grad[i], g->depth[i], share, &to->depth[i], to_opacity);
    if (map == FFP_MAP_NORMAL) normal_backward(g->normal + 3 * i, grad + 3 * i, to->normal + 3 * i);
    if (map == FFP_MAP_ROUGHNESS)
        mean_backward(grad[i], g->roughness[i], share, &to->roughness[i], to_opacity);
    for (size_t c = 3 * i; c < 3 * i + 3; c++) {
        if (map == FFP_MAP_ALBEDO) mean_backward(grad[c], g->albedo[c], share, &to->albedo[c], to_opacity);
        if (map == FFP_MAP_AMBIENT) to->ambient[c] += grad[c];
    }
}

void ffp_map_values_backward(const FfpGbuffer *gbuffer, FfpMap map, const float *grad, FfpGbuffer *to) {
    const size_t pixels = (size_t)gbuffer->width * (size_t)gbuffer->height;
    for (size_t i = 0; i < pixels; i++) values_backward(gbuffer, map, i, grad, to);
}
