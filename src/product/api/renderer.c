// Drawing into the caller's memory.
#include "engine/pipeline/renderer.h"
#include "engine/pipeline/maps.h"
#include "product/api/arguments.h"
#include "product/api/memory.h"

typedef struct NewCall {
    FfpDrawing drawing;
    FfpRenderer *renderer;
} NewCall;

static bool make(void *argument, FfpError *err) {
    (void)err;
    NewCall *call = argument;
    call->renderer = ffp_renderer_make(call->drawing);
    return true;
}

FfpRenderer *ffp_renderer_new(FfpContext *context, FfpDrawing drawing, FfpError *err) {
    NewCall call = {drawing, NULL};
    if (!ffp_check_drawing(drawing, err)) return NULL;
    return ffp_call_run(context, make, &call, err) ? call.renderer : NULL;
}

void ffp_renderer_close(FfpRenderer *renderer) {
    if (renderer) ffp_renderer_free(renderer);
}

typedef struct AimCall {
    FfpRenderer *renderer;
    const FfpGaussians *gaussians;
    const FfpPinhole *camera, *projector;
} AimCall;

static bool aim(void *argument, FfpError *err) {
    const AimCall *call = argument;
    FfpCamera camera, projector;
    call->renderer->aimed = false; // whatever becomes of it
    if (!ffp_camera_of(&camera, call->camera, 1, "camera", err) ||
        !ffp_camera_of(&projector, call->projector, 1, "projector", err))
        return false;
    ffp_renderer_draw(call->renderer, call->gaussians, &camera, &projector);
    return true;
}

bool ffp_renderer_aim(FfpContext *context, FfpRenderer *renderer, const FfpGaussians *gaussians,
                      const FfpPinhole *camera, const FfpPinhole *projector, FfpError *err) {
    AimCall call = {renderer, gaussians, camera, projector};
    if (!ffp_need(renderer, "renderer", err) || !ffp_need_gaussians(gaussians, err) ||
        !ffp_need(camera, "camera", err) || !ffp_need(projector, "projector", err))
        return false;
    return ffp_call_run(context, aim, &call, err);
}

typedef struct ShadeCall {
    FfpRenderer *renderer;
    const FfpPicture *pattern;
    const double *intensity;
    FfpPictureOut out;
} ShadeCall;

static bool shade(void *argument, FfpError *err) {
    const ShadeCall *call = argument;
    const FfpRaw pattern = call->pattern ? ffp_raw_of(call->pattern) : (FfpRaw){0};
    return ffp_renderer_relight(call->renderer, &pattern, call->intensity, call->out, err);
}

bool ffp_renderer_shade(FfpContext *context, FfpRenderer *renderer, const FfpPicture *pattern,
                        const double intensity[3], void *out, size_t size, FfpPixelType type,
                        size_t row_bytes, FfpError *err) {
    ShadeCall call = {renderer, pattern, intensity, {out, size, type, row_bytes}};
    if (!ffp_need(renderer, "renderer", err) || !ffp_need(intensity, "intensity", err) ||
        !ffp_need(out, "out", err))
        return false;
    return ffp_call_run(context, shade, &call, err);
}

int ffp_map_channels(FfpMap map) {
    return ffp_map_width(map);
}

typedef struct MapCall {
    FfpRenderer *renderer;
    FfpMap map;
    float *out;
    size_t count;
} MapCall;

static bool give_map(void *argument, FfpError *err) {
    const MapCall *call = argument;
    return ffp_renderer_values(call->renderer, call->map, call->out, call->count, err);
}

bool ffp_renderer_map(FfpContext *context, FfpRenderer *renderer, FfpMap map, float *out, size_t count,
                      FfpError *err) {
    MapCall call = {renderer, map, out, count};
    if (!ffp_need(renderer, "renderer", err) || !ffp_need(out, "out", err)) return false;
    return ffp_call_run(context, give_map, &call, err);
}
