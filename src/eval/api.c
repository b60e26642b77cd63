// The handles of the public header: opening, saving, closing; training and generation.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "ffprocams.h"
#include "base/arena.h"
#include "base/file.h"
#include "capture/capture.h"
#include "gaussians/gaussians.h"
#include "network/network.h"
#include "train/train.h"

#define SHIPPED_MODEL "models/small.safetensors"

const char *ffp_version(void) {
    return FFP_VERSION;
}

FfpCapture *ffp_capture_open(const char *path, FfpError *err) {
    FfpCapture *capture = ffp_alloc(1, sizeof *capture);
    if (ffp_capture_read(capture, path, err)) return capture;
    free(capture);
    return NULL;
}

bool ffp_capture_save(const FfpCapture *capture, const char *folder, FfpError *err) {
    return ffp_capture_write_whole(capture, folder, NULL, NULL, err);
}

bool ffp_can_save_capture(const char *folder, FfpError *err) {
    return ffp_capture_probe(folder, err);
}

void ffp_capture_close(FfpCapture *capture) {
    if (!capture) return;
    ffp_capture_free(capture);
    free(capture);
}

// "<folder of the program>/../models/small.safetensors", then the same below the current folder.
static bool find_shipped_model(char path[FFP_PATH_MAX], FfpError *err) {
    char program[FFP_PATH_MAX];
    const ssize_t length = readlink("/proc/self/exe", program, sizeof program - 1);
    if (length > 0) {
        program[length] = 0;
        char *slash = strrchr(program, '/');
        if (slash) *slash = 0;
        if (slash && ffp_join_path(path, program, "../" SHIPPED_MODEL) && ffp_is_file(path)) return true;
    }
    snprintf(path, FFP_PATH_MAX, "%s", SHIPPED_MODEL);
    if (ffp_is_file(path)) return true;
    return ffp_fail(err, SHIPPED_MODEL,
                    "the shipped weights are neither beside the program's folder nor in the current one: "
                    "name a file, or none");
}

FfpModel *ffp_model_open(const char *path, FfpError *err) {
    char shipped[FFP_PATH_MAX];
    if (path) return ffp_model_read(path, err);
    return find_shipped_model(shipped, err) ? ffp_model_read(shipped, err) : NULL;
}

void ffp_model_close(FfpModel *model) {
    if (model) ffp_model_free(model);
}

FfpGaussians *ffp_gaussians_open(const char *path, FfpError *err) {
    FfpGaussians *gaussians = ffp_alloc(1, sizeof *gaussians);
    if (ffp_gaussians_read(gaussians, path, err)) return gaussians;
    free(gaussians);
    return NULL;
}

bool ffp_gaussians_save(const FfpGaussians *gaussians, const char *path, FfpError *err) {
    return ffp_gaussians_write(gaussians, path, 1.0F / 255, err); // the rasteriser never draws less than that
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
    free(gaussians);
}
