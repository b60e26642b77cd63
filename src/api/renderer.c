// Drawing into the caller's memory: one view rasterised, any number of patterns.
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "api/arguments.h"
#include "api/memory.h"
#include "api/relight.h"
#include "base/arena.h"
#include "base/call.h"
#include "base/real.h"

struct FfpRenderer {
    FfpBlocks blocks; // the pass's, which grows from call to call
    FfpRenderSettings settings;
    FfpViewPass *pass; // NULL: nothing was aimed at yet
    FfpSummed pattern; // shown last
    FfpCamera camera, projector;
    bool aimed;
};

typedef struct NewCall {
    FfpDrawing drawing;
    FfpRenderer *renderer;
} NewCall;

static void forget_pass(void *owner) {
    FfpRenderer *renderer = owner;
    renderer->pass = NULL;
    renderer->pattern = (FfpSummed){0};
    renderer->aimed = false;
}

static bool make(void *argument, FfpError *err) {
    (void)err;
    NewCall *call = argument;
    const FfpRenderSettings settings = ffp_drawing_settings(call->drawing, NULL);
    call->renderer = ffp_alloc(1, sizeof *call->renderer);
    call->renderer->settings = settings;
    ffp_blocks_init(&call->renderer->blocks, call->renderer, forget_pass);
    return true;
}

FfpRenderer *ffp_renderer_new(FfpContext *context, FfpDrawing drawing, FfpError *err) {
    NewCall call = {drawing, NULL};
    if (!ffp_check_drawing(drawing, err)) return NULL;
    return ffp_call_run(context, make, &call, err) ? call.renderer : NULL;
}

void ffp_renderer_close(FfpRenderer *renderer) {
    if (!renderer) return;
    ffp_blocks_close(&renderer->blocks);
    ffp_free(renderer);
}

typedef struct AimCall {
    FfpRenderer *renderer;
    const FfpGaussians *gaussians;
    const FfpPinhole *camera, *projector;
} AimCall;

static bool aim(void *argument, FfpError *err) {
    const AimCall *call = argument;
    FfpRenderer *renderer = call->renderer;
    renderer->aimed = false;
    if (!ffp_camera_of(&renderer->camera, call->camera, 1, "camera", err) ||
        !ffp_camera_of(&renderer->projector, call->projector, 1, "projector", err))
        return false;
    ffp_blocks_use(&renderer->blocks);
    if (!renderer->pass) renderer->pass = ffp_view_pass_new(&renderer->settings);
    ffp_view_pass_draw(renderer->pass, call->gaussians, &renderer->camera, &renderer->projector);
    ffp_blocks_use(NULL);
    renderer->aimed = true;
    return true;
}

bool ffp_renderer_aim(FfpContext *context, FfpRenderer *renderer, const FfpGaussians *gaussians,
                      const FfpPinhole *camera, const FfpPinhole *projector, FfpError *err) {
    AimCall call = {renderer, gaussians, camera, projector};
    if (!ffp_need(renderer, "renderer", err) || !ffp_need(gaussians, "gaussians", err) ||
        !ffp_need(camera, "camera", err) || !ffp_need(projector, "projector", err))
        return false;
    return ffp_call_run(context, aim, &call, err);
}

static bool check_aimed(const FfpRenderer *renderer, FfpError *err) {
    return renderer->aimed ||
           ffp_fail(err, FFP_ERROR_ARGUMENT, NULL, "the renderer is not aimed at anything");
}

// The pattern as the shader wants it.
static bool take_pattern(FfpRenderer *renderer, const FfpPicture *pattern, FfpError *err) {
    FfpImage image;
    const FfpRaw raw = ffp_raw_of(pattern);
    const FfpCamera *projector = &renderer->projector;
    if (raw.width != projector->width || raw.height != projector->height)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "pattern",
                        "%d x %d pixels do not fit a projector of %d x %d", raw.width, raw.height,
                        projector->width, projector->height);
    if (!ffp_raw_over_black(&image, NULL, &raw, "pattern", err)) return false;
    ffp_blocks_use(&renderer->blocks);
    ffp_summed_fill(&renderer->pattern, &image);
    ffp_blocks_use(NULL);
    ffp_image_free(&image);
    return true;
}

static void put_picture(void *out, FfpPixelType type, size_t row_bytes, const FfpImage *picture) {
    const size_t count = 3 * (size_t)picture->width;
    for (int y = 0; y < picture->height; y++) {
        const real *from = picture->data + (size_t)y * count;
        unsigned char *row = (unsigned char *)out + (size_t)y * row_bytes;
        if (type == FFP_PIXELS_F32)
            memcpy(row, from, count * sizeof(float));
        else
            for (size_t i = 0; i < count; i++) row[i] = (unsigned char)(from[i] * 255 + 0.5F);
    }
}

static bool shade(FfpRenderer *renderer, const FfpPicture *pattern, const double intensity[3], void *out,
                  FfpPixelType type, size_t row_bytes, FfpError *err) {
    if (!check_aimed(renderer, err)) return false;
    const size_t row = 3 * (size_t)renderer->camera.width * (type == FFP_PIXELS_F32 ? sizeof(float) : 1);
    if (type != FFP_PIXELS_F32 && type != FFP_PIXELS_U8)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "type",
                        "pictures are drawn as 8-bit or 32-bit float pixels");
    if (row_bytes != 0 && row_bytes < row)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "row_bytes", "rows of %zu bytes have no room for %zu",
                        row_bytes, row);
    real strength[3];
    for (int c = 0; c < 3; c++) {
        if (!(intensity[c] >= 0 && intensity[c] <= 1e18))
            return ffp_fail(err, FFP_ERROR_ARGUMENT, "intensity", "%g is out of range", intensity[c]);
        strength[c] = (real)intensity[c];
    }
    const bool dark = !pattern || !pattern->data;
    if (!dark && !take_pattern(renderer, pattern, err)) return false;
    FfpImage picture = ffp_view_pass_picture_new(renderer->pass);
    ffp_view_pass_shade(renderer->pass, strength, dark ? NULL : &renderer->pattern, &picture);
    if (type == FFP_PIXELS_U8) ffp_quantise(&picture);
    put_picture(out, type, row_bytes ? row_bytes : row, &picture);
    ffp_image_free(&picture);
    return true;
}

typedef struct ShadeCall {
    FfpRenderer *renderer;
    const FfpPicture *pattern;
    const double *intensity;
    void *out;
    FfpPixelType type;
    size_t row_bytes;
} ShadeCall;

static bool do_shade(void *argument, FfpError *err) {
    const ShadeCall *c = argument;
    return shade(c->renderer, c->pattern, c->intensity, c->out, c->type, c->row_bytes, err);
}

bool ffp_renderer_shade(FfpContext *context, FfpRenderer *renderer, const FfpPicture *pattern,
                        const double intensity[3], void *out, FfpPixelType type, size_t row_bytes,
                        FfpError *err) {
    ShadeCall call = {renderer, pattern, intensity, out, type, row_bytes};
    if (!ffp_need(renderer, "renderer", err) || !ffp_need(intensity, "intensity", err) ||
        !ffp_need(out, "out", err))
        return false;
    return ffp_call_run(context, do_shade, &call, err);
}

int ffp_map_channels(FfpMap map) {
    return map == FFP_MAP_NORMAL || map == FFP_MAP_ALBEDO || map == FFP_MAP_AMBIENT ? 3 : 1;
}

// Raw sums become means over what covers the pixel; opacity and ambient light are sums as they stand.
static void put_map(float *out, const FfpGbuffer *g, FfpMap map, size_t i) {
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
}

static bool put_maps(FfpRenderer *renderer, FfpMap map, float *out, FfpError *err) {
    if (!check_aimed(renderer, err)) return false;
    if ((unsigned)map >= FFP_MAP_COUNT)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "map", "there is no map %d", map);
    const FfpGbuffer *gbuffer = ffp_view_pass_gbuffer(renderer->pass);
    const size_t pixels = (size_t)gbuffer->width * (size_t)gbuffer->height;
    for (size_t i = 0; i < pixels; i++) put_map(out, gbuffer, map, i);
    return true;
}

typedef struct MapCall {
    FfpRenderer *renderer;
    FfpMap map;
    float *out;
} MapCall;

static bool do_map(void *argument, FfpError *err) {
    const MapCall *call = argument;
    return put_maps(call->renderer, call->map, call->out, err);
}

bool ffp_renderer_map(FfpContext *context, FfpRenderer *renderer, FfpMap map, float *out, FfpError *err) {
    MapCall call = {renderer, map, out};
    if (!ffp_need(renderer, "renderer", err) || !ffp_need(out, "out", err)) return false;
    return ffp_call_run(context, do_map, &call, err);
}
