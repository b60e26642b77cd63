// The parts that a training run works with, from its options to the end.
#include <stdio.h>
#include <string.h>
#include "core/base/call.h"
#include "core/base/device.h"
#include "core/base/file.h"
#include "core/base/log.h"
#include "core/capture/node.h"
#include "lab/train/trainer.h"
#include "world/synth/trace.h"

// How many of the first `most` bytes are whole characters of UTF-8.
static int whole(const char *text, int most) {
    int count = (int)strnlen(text, (size_t)most + 1);
    if (count <= most) return count;
    count = most;
    while (count > 0 && ((unsigned char)text[count] & 0xC0) == 0x80) count--;
    return count;
}

// "random", or the steps and the program of the weights that the run starts from.
static void log_origin(Trainer *trainer, const char *path) {
    const char *steps = "?", *by = "?";
    for (int i = 0; i < trainer->model->metadata_count; i++) {
        const char *key = trainer->model->metadata[2 * i], *value = trainer->model->metadata[2 * i + 1];
        if (strcmp(key, "trained_steps") == 0) steps = value;
        if (strcmp(key, "program") == 0) by = value;
    }
    const char *name = path ? ffp_basename(path) : "";
    if (!ffp_is_utf8(name)) name = "weights"; // the checkpoint holds no other text
    if (path)
        snprintf(trainer->origin, sizeof trainer->origin, "%.*s: %.*s steps by %.*s", whole(name, 60), name,
                 whole(steps, 20), steps, whole(by, 100), by);
    else
        snprintf(trainer->origin, sizeof trainer->origin, "random, from the seed");
}

// The weights to start from, in their own configuration except for fields that do not concern weights, and
// for context_inputs and looks, which begin without effect where the file has none.
static FfpModel *read_initial(const char *path, const FfpTrainConfig *config, FfpError *err) {
    FfpModel *model = ffp_model_read(path, err);
    if (!model) return NULL;
    model->config.samples = config->model.samples;
    model->config.tokens = config->model.tokens;
    FfpModelConfig wider = model->config;
    wider.context_inputs = wider.context_inputs || config->model.context_inputs;
    wider.looks = wider.looks > config->model.looks ? wider.looks : config->model.looks;
    if (wider.looks > model->config.looks) wider.look_hidden = config->model.look_hidden;
    if (wider.context_inputs == model->config.context_inputs && wider.looks == model->config.looks)
        return model;
    FfpModel *out = ffp_model_new(&wider, (uint64_t)config->seed, err);
    if (out) {
        ffp_model_take_over(out, model);
        out->metadata = model->metadata;
        out->metadata_count = model->metadata_count;
        model->metadata = NULL;
        model->metadata_count = 0;
    }
    ffp_model_free(model);
    return out;
}

static bool take_captures(FfpTrainConfig *config, const char *path, FfpError *err) {
    if (strlen(path) >= sizeof config->captures)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, path, "path is too long");
    if (!ffp_is_utf8(path))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, path,
                        "path is not UTF-8, so the checkpoint cannot record it");
    snprintf(config->captures, sizeof config->captures, "%s", path);
    return true;
}

// Where the layers of the looks begin, which are a model's last.
static int64_t first_of_looks(const FfpModel *model) {
    int64_t first = model->count;
    for (int i = model->n_parameters - 1; i >= 0; i--)
        if (strncmp(model->parameters[i].name, "look.", 5) == 0) first = model->parameters[i].offset;
    return first;
}

// The model and its configuration: from the checkpoint, from given weights, or new.
static bool open_model(Trainer *trainer, const FfpTrainRun *options, FfpError *err) {
    FfpTrainConfig *config = &trainer->config;
    char path[FFP_PATH_MAX];
    if (options->resume) {
        if (options->config || options->initial) {
            ffp_fail(err, FFP_ERROR_ARGUMENT, NULL,
                     "a resumed run takes its configuration and weights only from the checkpoint");
            return false;
        }
        if (!ffp_trainer_path(path, trainer, "checkpoint.safetensors", err)) return false;
        trainer->model = ffp_checkpoint_read(path, &trainer->adam, config, trainer->origin, err);
        if (options->steps >= 0) config->steps = options->steps;
        return trainer->model != NULL;
    }
    *config = options->captures ? ffp_fine_tuning_defaults() : ffp_train_defaults();
    if (options->captures && !take_captures(config, options->captures, err)) return false;
    if (options->config && !ffp_train_config_overlay(config, options->config, err)) return false;
    if (options->steps >= 0) config->steps = options->steps;
    trainer->model = options->initial ? read_initial(options->initial, config, err)
                                      : ffp_model_new(&config->model, (uint64_t)config->seed, err);
    if (!trainer->model) return false;
    config->model = trainer->model->config;
    log_origin(trainer, options->initial);
    trainer->adam = ffp_adam_new(trainer->model);
    return true;
}

static bool open_metrics(Trainer *trainer, bool resume, FfpError *err) {
    char path[FFP_PATH_MAX];
    if (!ffp_make_folders(trainer->out, err) || !ffp_trainer_path(path, trainer, "metrics.jsonl", err))
        return false;
    if (!resume && ffp_is_file(path))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, path,
                        "the folder already holds a run: resume it, or choose another folder");
    trainer->metrics = ffp_open_to_grow(path, true, err);
    if (trainer->metrics) ffp_own_file(trainer->metrics);
    return trainer->metrics != NULL;
}

// Opens the device, and the memory that steps need on it.
static void open_device(Trainer *trainer) {
    trainer->device = ffp_device_offered();
    ffp_device_use(trainer->device);
    if (trainer->device) trainer->mirror = ffp_mirror_new(trainer->model, &trainer->adam, &trainer->config);
    trainer->stepper = ffp_train_step_new(&trainer->config, trainer->perceptual);
    trainer->grad = ffp_memory_new((size_t)trainer->model->count, sizeof(real));
    ffp_device_use(NULL);
}

// This rank's part of the work and of the optimiser's state.
static bool open_share(Trainer *trainer, FfpError *err) {
    FfpShard *share = &trainer->share;
    ffp_shard_open(share, trainer->model->count);
    if (!ffp_shard_check(share, &trainer->config, trainer->adam.step, err)) return false;
    if (share->ranks) ffp_adam_keep(&trainer->adam, ffp_shard_first(share), ffp_shard_count(share));
    return true;
}

// The metrics file is opened after all that can be wrong: a folder that holds one counts as a run.
bool ffp_trainer_open(Trainer *trainer, const FfpTrainRun *options, FfpError *err) {
    trainer->out = options->out;
    if (!open_model(trainer, options, err)) return false;
    if (trainer->config.looks_only) trainer->adam.learning = first_of_looks(trainer->model);
    if (options->perceptual && !(trainer->perceptual = ffp_perceptual_read(options->perceptual, err)))
        return false;
    if (!options->perceptual && trainer->config.perceptual > 0)
        ffp_note("no perceptual weights given: the perceptual term is off");
    const char *scenes = trainer->config.scenes;
    if (scenes[0] && !ffp_scene_folder_open(&trainer->folder, scenes, err)) return false;
    // Other runs validate on generated scenes, wherever those come from that they learn from.
    if (!trainer->config.captures[0] && !ffp_tracer_available(err)) return false;
    if (!ffp_stock_open(&trainer->stock, trainer->config.materials, trainer->config.patterns, err) ||
        !open_share(trainer, err))
        return false;
    if (trainer->config.captures[0] && !ffp_held_out_open(trainer, err)) return false;
    if (trainer->config.rooms[0] && !(trainer->rooms = ffp_rooms_open(&trainer->config, err))) return false;
    if (ffp_trainer_is_first(trainer) && !open_metrics(trainer, options->resume, err)) return false;
    open_device(trainer);
    return true;
}

static void close_device(Trainer *trainer) {
    ffp_device_use(trainer->device);
    ffp_mirror_free(trainer->mirror, &trainer->config);
    ffp_train_step_free(trainer->stepper);
    ffp_perceptual_free(trainer->perceptual);
    ffp_memory_free(trainer->grad);
    ffp_device_use(NULL);
}

void ffp_trainer_close(Trainer *trainer) {
    ffp_stream_free(trainer->scenes);
    ffp_scene_folder_close(&trainer->folder);
    ffp_stock_close(&trainer->stock);
    ffp_captures_close(trainer->captures);
    ffp_captures_close(trainer->rooms);
    close_device(trainer);
    ffp_shard_close(&trainer->share);
    ffp_adam_free(&trainer->adam);
    ffp_model_free(trainer->model);
    if (trainer->metrics) ffp_close_file(trainer->metrics);
}
