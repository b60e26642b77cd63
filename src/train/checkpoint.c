// Checkpoints: everything a run needs to go on bit for bit, in one safetensors file.
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include "tensor/safetensors.h"
#include "train/train.h"

static const char *const names[] = {"values", "ema", "m", "v"};

static real *array_of(int i, const FfpModel *model, const FfpAdam *adam) {
    real *const arrays[] = {model->values, adam->ema, adam->m, adam->v};
    return arrays[i];
}

bool ffp_checkpoint_write(const char *path, const FfpModel *model, const FfpAdam *adam,
                          const FfpTrainConfig *config, const char *origin, FfpError *err) {
    FfpTensor tensors[4] = {0};
    for (int i = 0; i < 4; i++) {
        strcpy(tensors[i].name, names[i]);
        tensors[i].dtype = FFP_F32;
        tensors[i].rank = 1;
        tensors[i].shape[0] = tensors[i].count = model->count;
        tensors[i].data = array_of(i, model, adam);
    }
    char step[32];
    snprintf(step, sizeof step, "%lld", (long long)adam->step);
    char *text = ffp_train_config_print(config);
    const char *const metadata[] = {
        "format", "ffprocams-checkpoint-1", "step", step, "config", text, "origin", origin};
    const bool ok = ffp_safetensors_write(path, tensors, 4, metadata, 4, err);
    free(text);
    return ok;
}

static bool read_arrays(const FfpSafetensors *file, const char *path, FfpModel *model, FfpAdam *adam,
                        FfpError *err) {
    for (int i = 0; i < 4; i++) {
        char where[1200];
        snprintf(where, sizeof where, "%s: %s", path, names[i]);
        const FfpTensor *tensor = ffp_safetensors_find(file, names[i]);
        if (!tensor) return ffp_fail(err, where, "missing tensor");
        if (tensor->dtype != FFP_F32 || tensor->count != model->count)
            return ffp_fail(err, where, "expected %lld F32 values", (long long)model->count);
        ffp_tensor_to_real(tensor, array_of(i, model, adam));
    }
    return true;
}

static bool read_step(const FfpSafetensors *file, const char *path, int64_t *step, FfpError *err) {
    const char *format = ffp_safetensors_metadata(file, "format"),
               *text = ffp_safetensors_metadata(file, "step");
    if (!format || strcmp(format, "ffprocams-checkpoint-1") != 0)
        return ffp_fail(err, path, "not a checkpoint of this program's training");
    char *end = NULL;
    errno = 0;
    *step = text ? strtoll(text, &end, 10) : -1;
    if (!text || errno || *end || *step < 0)
        return ffp_fail(err, path, "the step count is missing or broken");
    return true;
}

// Takes the configuration and the step out of the metadata.
static bool read_metadata(const FfpSafetensors *file, const char *path, FfpTrainConfig *config, int64_t *step,
                          FfpError *err) {
    const char *text = ffp_safetensors_metadata(file, "config");
    if (!read_step(file, path, step, err)) return false;
    if (!text) return ffp_fail(err, path, "no configuration in the metadata");
    return ffp_train_config_parse(config, text, path, err);
}

FfpModel *ffp_checkpoint_read(const char *path, FfpAdam *adam, FfpTrainConfig *config,
                              char origin[FFP_ORIGIN_MAX], FfpError *err) {
    FfpSafetensors file;
    if (!ffp_safetensors_read(&file, path, err)) return NULL;
    int64_t step = 0;
    FfpModel *model = NULL;
    if (read_metadata(&file, path, config, &step, err)) model = ffp_model_new(&config->model, 0, err);
    if (model) {
        *adam = ffp_adam_new(model);
        adam->step = step;
        const char *told = ffp_safetensors_metadata(&file, "origin");
        snprintf(origin, FFP_ORIGIN_MAX, "%s", told ? told : "unknown");
        if (!read_arrays(&file, path, model, adam, err)) {
            ffp_adam_free(adam);
            ffp_model_free(model);
            model = NULL;
        }
    }
    ffp_safetensors_free(&file);
    return model;
}
