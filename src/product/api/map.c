// Correspondence maps and what the projector lights.
#include "core/base/call.h"
#include "engine/pipeline/correspondence.h"
#include "product/api/arguments.h"
#include "product/api/memory.h"
#include "product/export/map_files.h"

void ffp_maps_defaults_into(FfpMaps *options, size_t size) {
    ffp_give_defaults(options, size, &(FfpMaps){0}, sizeof(FfpMaps));
}

typedef struct MemoryCall {
    const FfpGaussians *gaussians;
    const FfpCapture *capture;
    const FfpPinhole *camera, *projector;
    FfpDrawing drawing;
    FfpMapStats *stats;
    FfpImages *images;
} MemoryCall;

static bool into_memory(void *argument, FfpError *err) {
    MemoryCall *call = argument;
    FfpView view = {.id = "view"};
    if (!ffp_camera_of(&view.camera, call->camera, 1, "camera", err) ||
        !ffp_camera_of(&view.projector, call->projector, 1, "projector", err))
        return false;
    call->images = ffp_maps_of_view(call->gaussians, call->capture, &view, call->drawing, call->stats, err);
    return call->images != NULL;
}

FfpImages *ffp_map_images(FfpContext *context, const FfpGaussians *gaussians, const FfpCapture *capture,
                          const FfpPinhole *camera, const FfpPinhole *projector, FfpDrawing drawing,
                          FfpMapStats *stats, FfpError *err) {
    MemoryCall call = {gaussians, capture, camera, projector, drawing, stats, NULL};
    if (!ffp_need_gaussians(gaussians, err) || !ffp_need(capture, "capture", err) ||
        !ffp_need(camera, "camera", err) || !ffp_need(projector, "projector", err) ||
        !ffp_check_drawing(drawing, err))
        return NULL;
    return ffp_call_run(context, into_memory, &call, err) ? call.images : NULL;
}

typedef struct FilesCall {
    const FfpGaussians *gaussians;
    const FfpCapture *capture;
    const FfpMaps *options;
    FfpMapStats *stats;
    int n_stats, written;
} FilesCall;

static bool into_files(void *argument, FfpError *err) {
    FilesCall *call = argument;
    call->written =
        ffp_maps_run(call->gaussians, call->capture, call->options, call->stats, call->n_stats, err);
    return call->written >= 0;
}

int ffp_write_maps(FfpContext *context, const FfpGaussians *gaussians, const FfpCapture *capture,
                   const FfpMaps *options, FfpMapStats *stats, int n_stats, FfpError *err) {
    FfpMaps own = ffp_maps_defaults();
    FilesCall call = {gaussians, capture, &own, stats, n_stats, 0};
    if (!ffp_need_gaussians(gaussians, err) || !ffp_need(capture, "capture", err) ||
        !ffp_take_options(&own, options, "FfpMaps", err) || !ffp_need(own.folder, "folder", err) ||
        !ffp_need_texts(own.views, own.n_views, "views", err) || !ffp_check_drawing(own.drawing, err))
        return -1;
    return ffp_call_run(context, into_files, &call, err) ? call.written : -1;
}
