// The handles of the public headers: opening, saving, closing.
#include <stdio.h>
#include <stdlib.h>
#include "core/base/arena.h"
#include "core/base/call.h"
#include "core/base/file.h"
#include "core/capture/capture.h"
#include "core/gaussians/gaussians.h"
#include "engine/network/shipped.h"
#include "ffprocams.h"
#include "product/api/arguments.h"
#include "product/api/source.h"

const char *ffp_version(void) {
    return FFP_VERSION;
}

void ffp_opening_defaults_into(FfpOpening *options, size_t size) {
    ffp_give_defaults(options, size, &(FfpOpening){0}, sizeof(FfpOpening));
}

typedef struct OpenCapture {
    const char *path;
    const FfpOpening *options;
    FfpCapture *capture;
} OpenCapture;

static bool open_capture(void *argument, FfpError *err) {
    OpenCapture *call = argument;
    const FfpOpening *o = call->options;
    switch (o->photographs) {
    case FFP_READ_ALL:
        call->capture = ffp_capture_load(call->path, err);
        break;
    case FFP_READ_WANTED:
        call->capture = ffp_capture_load_wanted(call->path, o->patterns, o->n_patterns, err);
        break;
    case FFP_READ_NONE:
        call->capture = ffp_capture_load_devices(call->path, o->sphere, err);
        break;
    }
    return call->capture != NULL;
}

FfpCapture *ffp_capture_open(FfpContext *context, const char *path, const FfpOpening *options,
                             FfpError *err) {
    FfpOpening own = ffp_opening_defaults();
    OpenCapture call = {.path = path, .options = &own};
    if (!ffp_need(path, "path", err) || (options && !ffp_take_options(&own, options, "FfpOpening", err)) ||
        !ffp_check_choice((int)own.photographs, FFP_READ_NONE, "photographs", err) ||
        !ffp_need_texts(own.patterns, own.n_patterns, "patterns", err))
        return NULL;
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
    if (!ffp_need_photographs(capture, err) || !ffp_need(folder, "folder", err)) return false;
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
    FfpFileSource source;
    FfpModel *model;
} OpenModel;

static bool open_model(void *argument, FfpError *err) {
    OpenModel *call = argument;
    ffp_source_use(&call->source);
    call->model = ffp_model_load(call->source.path, err);
    ffp_memory_file_use(NULL);
    return call->model != NULL;
}

FfpModel *ffp_model_open(FfpContext *context, const char *path, const FfpBytes *contents, FfpError *err) {
    OpenModel call = {0};
    if (!ffp_source_find(&call.source, path, contents, err)) return NULL;
    return ffp_call_run(context, open_model, &call, err) ? call.model : NULL;
}

void ffp_model_close(FfpModel *model) {
    if (model) ffp_model_free(model);
}

typedef struct OpenGaussians {
    FfpFileSource source;
    FfpGaussians *gaussians;
} OpenGaussians;

static bool open_gaussians(void *argument, FfpError *err) {
    OpenGaussians *call = argument;
    ffp_source_use(&call->source);
    call->gaussians = ffp_gaussians_load(call->source.path, err);
    ffp_memory_file_use(NULL);
    return call->gaussians != NULL;
}

FfpGaussians *ffp_gaussians_open(FfpContext *context, const char *path, const FfpBytes *contents,
                                 FfpError *err) {
    OpenGaussians call = {0};
    if (!ffp_source_find(&call.source, path, contents, err) || !ffp_need(call.source.path, "path", err))
        return NULL;
    return ffp_call_run(context, open_gaussians, &call, err) ? call.gaussians : NULL;
}

typedef struct SaveGaussians {
    const FfpGaussians *gaussians;
    const char *path;
} SaveGaussians;

static bool save_gaussians(void *argument, FfpError *err) {
    const SaveGaussians *call = argument;
    return ffp_gaussians_write_drawn(call->gaussians, call->path, err);
}

bool ffp_gaussians_save(FfpContext *context, const FfpGaussians *gaussians, const char *path, FfpError *err) {
    SaveGaussians call = {gaussians, path};
    if (!ffp_need_gaussians(gaussians, err) || !ffp_need(path, "path", err)) return false;
    return ffp_call_run(context, save_gaussians, &call, err);
}

typedef struct WriteGaussians {
    const FfpGaussians *gaussians;
    FfpMemoryFile file;
} WriteGaussians;

static bool write_gaussians(void *argument, FfpError *err) {
    WriteGaussians *call = argument;
    ffp_memory_file_use(&call->file);
    const bool ok = ffp_gaussians_write_drawn(call->gaussians, call->file.path, err);
    ffp_memory_file_use(NULL);
    return ok;
}

void *ffp_gaussians_bytes(FfpContext *context, const FfpGaussians *gaussians, size_t *size, FfpError *err) {
    WriteGaussians call = {gaussians, {.path = "gaussians"}};
    if (!ffp_need_gaussians(gaussians, err) || !ffp_need(size, "size", err)) return NULL;
    if (!ffp_call_run(context, write_gaussians, &call, err)) return NULL;
    *size = call.file.size;
    return call.file.written;
}

bool ffp_can_write(const char *path, FfpError *err) {
    return ffp_need(path, "path", err) && ffp_output_probe(path, err);
}

int64_t ffp_gaussians_count(const FfpGaussians *gaussians) {
    return gaussians->count;
}

void ffp_gaussians_close(FfpGaussians *gaussians) {
    if (!gaussians) return;
    ffp_gaussians_free(gaussians);
    ffp_free(gaussians);
}
