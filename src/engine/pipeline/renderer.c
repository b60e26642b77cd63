#include "engine/pipeline/renderer.h"
#include <string.h>
#include "core/base/alloc.h"
#include "engine/pipeline/maps.h"
#include "engine/pipeline/relight.h"

static void forget_pass(void *owner) {
    FfpRenderer *renderer = owner;
    renderer->pass = NULL;
    renderer->pattern = (FfpSummed){0};
    renderer->aimed = false;
    renderer->batch = NULL;
}

FfpRenderer *ffp_renderer_make(FfpDrawing drawing) {
    FfpRenderer *renderer = ffp_alloc(1, sizeof *renderer);
    renderer->settings = ffp_showing_settings(drawing);
    ffp_blocks_init(&renderer->blocks, renderer, forget_pass);
    return renderer;
}

void ffp_renderer_free(FfpRenderer *renderer) {
    ffp_blocks_close(&renderer->blocks);
    ffp_free(renderer);
}

void ffp_renderer_draw(FfpRenderer *renderer, const FfpGaussians *gaussians, const FfpCamera *camera,
                       const FfpCamera *projector) {
    renderer->camera = *camera;
    renderer->projector = *projector;
    ffp_blocks_use(&renderer->blocks);
    if (!renderer->pass) renderer->pass = ffp_view_pass_new(&renderer->settings);
    ffp_view_pass_draw(renderer->pass, gaussians, &renderer->camera, &renderer->projector);
    ffp_blocks_use(NULL);
    renderer->aimed = true;
}

FfpBatch *ffp_renderer_batch(FfpRenderer *renderer) {
    ffp_blocks_use(&renderer->blocks);
    if (!renderer->batch) renderer->batch = ffp_batch_new(&renderer->settings);
    return renderer->batch;
}

static bool check_aimed(const FfpRenderer *renderer, FfpError *err) {
    return renderer->aimed ||
           ffp_fail(err, FFP_ERROR_ARGUMENT, NULL, "the renderer is not aimed at anything");
}

// The pattern as the shader wants it.
static bool take_pattern(FfpRenderer *renderer, const FfpRaw *pattern, FfpError *err) {
    FfpImage image;
    const FfpCamera *projector = &renderer->projector;
    if (pattern->width != projector->width || pattern->height != projector->height)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "pattern",
                        "%d x %d pixels do not fit a projector of %d x %d", pattern->width, pattern->height,
                        projector->width, projector->height);
    if (!ffp_raw_over_black(&image, NULL, pattern, "pattern", err)) return false;
    ffp_blocks_use(&renderer->blocks);
    ffp_summed_fill(&renderer->pattern, &image);
    ffp_blocks_use(NULL);
    ffp_image_free(&image);
    return true;
}

// The last row ends with its last pixel.
static bool check_out(const FfpPictureOut *out, size_t row, int height, FfpError *err) {
    if (out->type != FFP_PIXELS_F32 && out->type != FFP_PIXELS_RADIANCE && out->type != FFP_PIXELS_U8)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "type",
                        "pictures are drawn as 8-bit or 32-bit float pixels");
    const size_t apart = out->row_bytes ? out->row_bytes : row;
    if (apart < row || (out->type != FFP_PIXELS_U8 && apart % sizeof(float) != 0))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "row_bytes",
                        "rows of %zu bytes do not hold %zu, in whole numbers", apart, row);
    return (out->size >= row && (out->size - row) / apart >= (size_t)height - 1) ||
           ffp_fail(err, FFP_ERROR_ARGUMENT, "size", "%zu bytes cannot hold %d rows of %zu", out->size,
                    height, apart);
}

static bool take_intensity(const double intensity[3], real strength[3], FfpError *err) {
    for (int c = 0; c < 3; c++) {
        if (!(intensity[c] >= 0 && intensity[c] <= 1e18))
            return ffp_fail(err, FFP_ERROR_ARGUMENT, "intensity", "%g is out of range", intensity[c]);
        strength[c] = (real)intensity[c];
    }
    return true;
}

static void put_picture(const FfpPictureOut *out, size_t row_bytes, const FfpImage *picture) {
    const size_t count = 3 * (size_t)picture->width;
    for (int y = 0; y < picture->height; y++) {
        const real *from = picture->data + (size_t)y * count;
        unsigned char *row = (unsigned char *)out->pixels + (size_t)y * row_bytes;
        if (out->type != FFP_PIXELS_U8)
            memcpy(row, from, count * sizeof(float));
        else
            for (size_t i = 0; i < count; i++) row[i] = (unsigned char)(from[i] * 255 + 0.5F);
    }
}

bool ffp_renderer_relight(FfpRenderer *renderer, const FfpRaw *pattern, const double intensity[3],
                          FfpPictureOut out, FfpError *err) {
    if (!check_aimed(renderer, err)) return false;
    const FfpCamera *camera = &renderer->camera;
    const size_t row = 3 * (size_t)camera->width * (out.type == FFP_PIXELS_U8 ? 1 : sizeof(float));
    real strength[3];
    if (!check_out(&out, row, camera->height, err) || !take_intensity(intensity, strength, err)) return false;
    const bool dark = !pattern->data;
    if (!dark && !take_pattern(renderer, pattern, err)) return false;
    FfpImage picture = ffp_view_pass_picture_new(renderer->pass);
    const FfpSummed *light = dark ? NULL : &renderer->pattern;
    if (out.type == FFP_PIXELS_RADIANCE)
        ffp_view_pass_radiance(renderer->pass, strength, light, &picture);
    else
        ffp_view_pass_shade(renderer->pass, strength, light, &picture);
    if (out.type == FFP_PIXELS_U8) ffp_quantise(&picture);
    put_picture(&out, out.row_bytes ? out.row_bytes : row, &picture);
    ffp_image_free(&picture);
    return true;
}

bool ffp_renderer_values(FfpRenderer *renderer, FfpMap map, float *out, size_t count, FfpError *err) {
    if (!check_aimed(renderer, err) || !ffp_check_choice((int)map, FFP_MAP_COUNT - 1, "map", err))
        return false;
    const FfpCamera *camera = &renderer->camera;
    const size_t numbers = (size_t)camera->width * (size_t)camera->height * (size_t)ffp_map_width(map);
    if (count < numbers)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "count", "the map has %zu numbers, not %zu", numbers, count);
    ffp_map_values(ffp_view_pass_gbuffer(renderer->pass), map, out);
    return true;
}
