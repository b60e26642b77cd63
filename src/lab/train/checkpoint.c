// Checkpoints: everything a run needs to go on bit for bit, in one safetensors file.
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/call.h"
#include "core/tensor/safetensors.h"
#include "lab/train/train.h"

#define FORMAT "ffprocams-checkpoint-1"

static const char *const names[] = {"values", "ema", "m", "v"};
enum { ARRAYS = sizeof names / sizeof *names };

static real *array_of(int i, const FfpModel *model, const FfpAdam *adam) {
    real *const arrays[] = {model->values, adam->ema, adam->m, adam->v};
    return arrays[i];
}

bool ffp_checkpoint_write(const char *path, const FfpModel *model, const FfpAdam *adam,
                          const FfpTrainConfig *config, const char *origin, FfpError *err) {
    FfpTensor tensors[ARRAYS] = {0};
    for (int i = 0; i < ARRAYS; i++) {
        snprintf(tensors[i].name, sizeof tensors[i].name, "%s", names[i]);
        tensors[i].dtype = FFP_F32;
        tensors[i].rank = 1;
        tensors[i].shape[0] = tensors[i].count = model->count;
        tensors[i].data = array_of(i, model, adam);
    }
    char step[32];
    snprintf(step, sizeof step, "%lld", (long long)adam->step);
    char *text = ffp_train_config_print(config, err);
    if (!text) return false;
    const char *const metadata[] = {"format", FORMAT, "step", step, "config", text, "origin", origin};
    const bool ok = ffp_safetensors_write(path, tensors, ARRAYS, metadata, 4, err);
    ffp_free(text);
    return ok;
}

// Before memory is taken for what the configuration merely claims.
static bool check_arrays(const FfpSafetensors *file, const char *path, int64_t count, FfpError *err) {
    for (int i = 0; i < ARRAYS; i++) {
        const FfpPlace where = ffp_place(path, names[i]);
        const FfpTensor *tensor = ffp_safetensors_find(file, names[i]);
        if (!tensor) return ffp_fail(err, FFP_ERROR_FILE, where.text, "missing tensor");
        if (tensor->dtype != FFP_F32 || tensor->count != count)
            return ffp_fail(err, FFP_ERROR_FILE, where.text, "expected %lld F32 values", (long long)count);
    }
    return true;
}

static bool read_arrays(const FfpSafetensors *file, const char *path, FfpModel *model, FfpAdam *adam,
                        FfpError *err) {
    for (int i = 0; i < ARRAYS; i++) {
        real *array = array_of(i, model, adam);
        ffp_tensor_to_real(ffp_safetensors_find(file, names[i]), array);
        for (int64_t k = 0; k < model->count; k++)
            if (!isfinite(array[k]))
                return ffp_fail(err, FFP_ERROR_FILE, ffp_place(path, names[i]).text,
                                "value %lld is not finite", (long long)k);
    }
    return true;
}

// Takes the step and the configuration out of the metadata.
static bool read_metadata(const FfpSafetensors *file, const char *path, FfpTrainConfig *config, int64_t *step,
                          FfpError *err) {
    const char *format = ffp_safetensors_metadata(file, "format");
    const char *count = ffp_safetensors_metadata(file, "step");
    const char *text = ffp_safetensors_metadata(file, "config");
    if (!format || strcmp(format, FORMAT) != 0)
        return ffp_fail(err, FFP_ERROR_FILE, ffp_place(path, "format").text,
                        "not a checkpoint of this program's training");
    char *end = NULL;
    errno = 0;
    *step = count ? strtoll(count, &end, 10) : -1;
    if (!count || errno || end == count || *end || *step < 0)
        return ffp_fail(err, FFP_ERROR_FILE, ffp_place(path, "step").text,
                        "the step count is missing or broken");
    if (!text) return ffp_fail(err, FFP_ERROR_FILE, ffp_place(path, "config").text, "missing metadata");
    return ffp_train_config_parse(config, text, path, err);
}

FfpModel *ffp_checkpoint_read(const char *path, FfpAdam *adam, FfpTrainConfig *config,
                              char origin[FFP_ORIGIN_MAX], FfpError *err) {
    FfpSafetensors file;
    if (!ffp_safetensors_read(&file, path, err)) return NULL;
    int64_t step = 0;
    FfpModel *model = NULL;
    if (read_metadata(&file, path, config, &step, err)) model = ffp_model_table(&config->model, path, err);
    bool ok = model && check_arrays(&file, path, model->count, err);
    if (ok) {
        model->values = ffp_alloc((size_t)model->count, sizeof *model->values);
        *adam = ffp_adam_new(model);
        adam->step = step;
        const char *told = ffp_safetensors_metadata(&file, "origin");
        snprintf(origin, FFP_ORIGIN_MAX, "%s", told ? told : "unknown");
        ok = read_arrays(&file, path, model, adam, err);
        if (!ok) ffp_adam_free(adam);
    }
    ffp_safetensors_free(&file);
    if (ok) return model;
    ffp_model_free(model);
    return NULL;
}
