// The handles of the public header: opening, saving, closing.
#include <stdio.h>
#include <stdlib.h>
#include "api/arguments.h"
#include "ffprocams.h"
#include "api/weights.h"
#include "base/arena.h"
#include "base/call.h"
#include "base/file.h"
#include "capture/capture.h"
#include "gaussians/gaussians.h"
#include "network/network.h"

const char *ffp_version(void) {
    return FFP_VERSION;
}

typedef struct OpenCapture {
    const char *path;
    FfpCapture *capture;
} OpenCapture;

static bool open_capture(void *argument, FfpError *err) {
    OpenCapture *call = argument;
    call->capture = ffp_alloc(1, sizeof *call->capture);
    if (ffp_capture_read(call->capture, call->path, err)) return true;
    ffp_free(call->capture);
    return false;
}

FfpCapture *ffp_capture_open(FfpContext *context, const char *path, FfpError *err) {
    OpenCapture call = {.path = path};
    if (!ffp_need(path, "path", err)) return NULL;
    return ffp_call_run(context, open_capture, &call, err) ? call.capture : NULL;
}

typedef struct SaveCapture {
    const FfpCapture *capture;
    const char *folder;
} SaveCapture;

static bool save_capture(void *argument, FfpError *err) {
    const SaveCapture *call = argument;
    return ffp_capture_write_whole(call->capture, call->folder, NULL, NULL, err);
}

bool ffp_capture_save(FfpContext *context, const FfpCapture *capture, const char *folder, FfpError *err) {
    SaveCapture call = {capture, folder};
    if (!ffp_need(capture, "capture", err) || !ffp_need(folder, "folder", err)) return false;
    return ffp_call_run(context, save_capture, &call, err);
}

bool ffp_can_save_capture(const char *folder, FfpError *err) {
    return ffp_need(folder, "folder", err) && ffp_capture_probe(folder, err);
}

void ffp_capture_close(FfpCapture *capture) {
    if (!capture) return;
    ffp_capture_free(capture);
    ffp_free(capture);
}

typedef struct OpenModel {
    const char *path;
    FfpModel *model;
} OpenModel;

static bool open_model(void *argument, FfpError *err) {
    OpenModel *call = argument;
    char shipped[FFP_PATH_MAX];
    if (!call->path && !ffp_find_weights(shipped, err)) return false;
    FfpModel *model = ffp_model_read(call->path ? call->path : shipped, err);
    if (model && call->path) model->file = ffp_copy_text(call->path);
    call->model = model;
    return model != NULL;
}

FfpModel *ffp_model_open(FfpContext *context, const char *path, FfpError *err) {
    OpenModel call = {.path = path};
    return ffp_call_run(context, open_model, &call, err) ? call.model : NULL;
}

void ffp_model_close(FfpModel *model) {
    if (model) ffp_model_free(model);
}

typedef struct OpenGaussians {
    const char *path;
    FfpGaussians *gaussians;
} OpenGaussians;

static bool open_gaussians(void *argument, FfpError *err) {
    OpenGaussians *call = argument;
    call->gaussians = ffp_alloc(1, sizeof *call->gaussians);
    if (ffp_gaussians_read(call->gaussians, call->path, err)) {
        if (call->gaussians->count > 0) return true;
        ffp_gaussians_free(call->gaussians);
        ffp_fail(err, FFP_ERROR_FILE, call->path,
                 "holds no Gaussians: there is nothing to draw or to refine");
    }
    ffp_free(call->gaussians);
    return false;
}

FfpGaussians *ffp_gaussians_open(FfpContext *context, const char *path, FfpError *err) {
    OpenGaussians call = {.path = path};
    if (!ffp_need(path, "path", err)) return NULL;
    return ffp_call_run(context, open_gaussians, &call, err) ? call.gaussians : NULL;
}

typedef struct SaveGaussians {
    const FfpGaussians *gaussians;
    const char *path;
} SaveGaussians;

static bool save_gaussians(void *argument, FfpError *err) {
    const SaveGaussians *call = argument;
    const float least = 1.0F / 255; // the rasteriser never draws less than that opacity
    bool any = false;
    for (int64_t i = 0; i < call->gaussians->count && !any; i++) any = call->gaussians->opacity[i] >= least;
    if (!any) return ffp_fail(err, FFP_ERROR_ARGUMENT, call->path, "no Gaussian is opaque enough to be seen");
    return ffp_gaussians_write(call->gaussians, call->path, least, err);
}

bool ffp_gaussians_save(FfpContext *context, const FfpGaussians *gaussians, const char *path, FfpError *err) {
    SaveGaussians call = {gaussians, path};
    if (!ffp_need(gaussians, "gaussians", err) || !ffp_need(path, "path", err)) return false;
    return ffp_call_run(context, save_gaussians, &call, err);
}

bool ffp_can_write(const char *path, FfpError *err) {
    return ffp_output_probe(path, err);
}

int64_t ffp_gaussians_count(const FfpGaussians *gaussians) {
    return gaussians->count;
}

void ffp_gaussians_close(FfpGaussians *gaussians) {
    if (!gaussians) return;
    ffp_gaussians_free(gaussians);
    ffp_free(gaussians);
}
