// Correspondence maps and what the projector lights.
#include "core/base/call.h"
#include "engine/pipeline/correspondence.h"
#include "product/api/arguments.h"
#include "product/api/memory.h"
#include "product/export/map_files.h"

void ffp_warps_defaults_into(FfpWarps *options, size_t size) {
    ffp_give_defaults(options, size, &(FfpWarps){0}, sizeof(FfpWarps));
}

typedef struct MemoryCall {
    const FfpGaussians *gaussians;
    const FfpCapture *capture;
    const FfpPinhole *camera, *projector;
    FfpDrawing drawing;
    FfpWarpStats *stats;
    FfpImages *images;
} MemoryCall;

static bool into_memory(void *argument, FfpError *err) {
    MemoryCall *call = argument;
    FfpView view = {.id = "view"};
    if (!ffp_camera_of(&view.camera, call->camera, 1, "camera", err) ||
        !ffp_camera_of(&view.projector, call->projector, 1, "projector", err))
        return false;
    call->images = ffp_warps_of_view(call->gaussians, call->capture, &view, call->drawing, call->stats, err);
    return call->images != NULL;
}

FfpImages *ffp_warp_images(FfpContext *context, const FfpGaussians *gaussians, const FfpCapture *capture,
                           const FfpPinhole *camera, const FfpPinhole *projector, FfpDrawing drawing,
                           FfpWarpStats *stats, FfpError *err) {
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
    const FfpWarps *options;
    FfpWarpStats *stats;
    int n_stats, written;
} FilesCall;

static bool into_files(void *argument, FfpError *err) {
    FilesCall *call = argument;
    call->written =
        ffp_warps_run(call->gaussians, call->capture, call->options, call->stats, call->n_stats, err);
    return call->written >= 0;
}

int ffp_write_warps(FfpContext *context, const FfpGaussians *gaussians, const FfpCapture *capture,
                    const FfpWarps *options, FfpWarpStats *stats, int n_stats, FfpError *err) {
    FfpWarps own = ffp_warps_defaults();
    FilesCall call = {gaussians, capture, &own, stats, n_stats, 0};
    if (!ffp_need_gaussians(gaussians, err) || !ffp_need(capture, "capture", err) ||
        !ffp_take_options(&own, options, "FfpWarps", err) || !ffp_need(own.folder, "folder", err) ||
        !ffp_need_texts(own.views, own.n_views, "views", err) || !ffp_check_drawing(own.drawing, err))
        return -1;
    return ffp_call_run(context, into_files, &call, err) ? call.written : -1;
}
