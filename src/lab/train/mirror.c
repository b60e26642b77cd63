#include "lab/train/mirror.h"
#include <stdlib.h>
#include "core/base/arena.h"
#include "core/base/device.h"

static FfpAdam upload_adam(const FfpAdam *adam) {
    const size_t count = (size_t)adam->count;
    return (FfpAdam){adam->count,
                     adam->step,
                     ffp_memory_uploaded(adam->m, count, sizeof(real)),
                     ffp_memory_uploaded(adam->v, count, sizeof(real)),
                     ffp_memory_uploaded(adam->ema, count, sizeof(real)),
                     adam->first,
                     adam->learning};
}

FfpMirror *ffp_mirror_new(const FfpModel *model, const FfpAdam *adam, const FfpTrainConfig *config) {
    FfpMirror *mirror = ffp_alloc(1, sizeof *mirror);
    mirror->model = ffp_model_uploaded(model);
    mirror->adam = upload_adam(adam);
    mirror->scenes = ffp_alloc((size_t)config->pool, sizeof *mirror->scenes);
    return mirror;
}

void ffp_mirror_free(FfpMirror *mirror, const FfpTrainConfig *config) {
    if (!mirror) return;
    for (int i = 0; i < config->pool; i++) ffp_scene_upload_free(&mirror->scenes[i]);
    ffp_free(mirror->scenes);
    ffp_memory_free(mirror->model.values);
    ffp_memory_free(mirror->adam.m);
    ffp_memory_free(mirror->adam.v);
    ffp_memory_free(mirror->adam.ema);
    ffp_free(mirror);
}

const FfpScene *ffp_mirror_scene(FfpMirror *mirror, int slot, bool fresh, const FfpScene *scene) {
    FfpScene *there = &mirror->scenes[slot];
    if (!fresh && there->prepared) return there;
    ffp_scene_upload_free(there);
    ffp_scene_upload(there, scene);
    return there;
}

void ffp_mirror_download(const FfpMirror *mirror, FfpModel *model, FfpAdam *adam) {
    const size_t bytes = (size_t)adam->count * sizeof(real);
    ffp_memory_download(model->values, mirror->model.values, (size_t)model->count * sizeof(real));
    ffp_memory_download(adam->m, mirror->adam.m, bytes);
    ffp_memory_download(adam->v, mirror->adam.v, bytes);
    ffp_memory_download(adam->ema, mirror->adam.ema, bytes);
    adam->step = mirror->adam.step;
}
