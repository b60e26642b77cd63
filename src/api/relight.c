#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>
#include "base/file.h"
#include "base/log.h"
#include "api/relight.h"

FfpImage ffp_relight(FfpViewPass *pass, const real intensity[3], const FfpSummed *pattern) {
    FfpImage picture = ffp_view_pass_picture_new(pass);
    ffp_view_pass_shade(pass, intensity, pattern, &picture);
    ffp_quantise(&picture);
    return picture;
}

void ffp_quantise(FfpImage *encoded) {
    const size_t count = (size_t)encoded->width * encoded->height * encoded->channels;
    for (size_t i = 0; i < count; i++)
        encoded->data[i] = floor(fmin(fmax(encoded->data[i], 0), 1) * 255 + 0.5F) / 255;
}

FfpRenderSettings ffp_drawing_settings(FfpDrawing drawing, const FfpModel *model) {
    if (!model && drawing.form == FFP_FORM_GS_PROCAMS) {
        FfpRenderSettings settings = ffp_render_gs_procams();
        if (drawing.samples > 0) settings.samples = drawing.samples;
        return settings;
    }
    const bool paper = model ? ffp_model_is_paper_form(&model->config) : drawing.form == FFP_FORM_PAPER;
    const int meant = model ? model->config.samples : 0;
    return ffp_render_settings(paper, drawing.samples ? drawing.samples : meant);
}

const char *ffp_map_name(FfpMap map) {
    static const char *const names[FFP_MAP_COUNT] = {"opacity", "depth",     "normal",
                                                     "albedo",  "roughness", "ambient"};
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
        if (depth.data[i] > 0) near = fmin(near, depth.data[i]), far = fmax(far, depth.data[i]);
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

bool ffp_pattern_read(FfpPattern *pattern, const char *path, int width, int height, FfpError *err) {
    *pattern = (FfpPattern){.novel = true};
    if (!ffp_image_read_over_black(&pattern->image, NULL, path, err)) return false;
    if (pattern->image.width != width || pattern->image.height != height) {
        ffp_note("pattern %s: resized from %d x %d to the projector's %d x %d", path, pattern->image.width,
                 pattern->image.height, width, height);
        FfpImage resized = ffp_image_resize(&pattern->image, width, height);
        ffp_image_free(&pattern->image);
        pattern->image = resized;
    }
    snprintf(pattern->name, sizeof pattern->name, "%s", ffp_basename(path));
    char *dot = strrchr(pattern->name, '.');
    if (dot && dot != pattern->name) *dot = 0;
    return true;
}

bool ffp_picture_path(char *out, size_t size, const char *folder, const char *view, const char *rest,
                      FfpError *err) {
    if (!*view || *view == '.' || strchr(view, '/') || strchr(rest, '/'))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, folder, "%s_%s is no name for a file", view, rest);
    if ((size_t)snprintf(out, size, "%s/%s_%s", folder, view, rest) >= size)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, folder, "the path of %s_%s is too long", view, rest);
    return true;
}
