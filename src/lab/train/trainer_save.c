// The files that a training run keeps: weights and checkpoints.
#include <stdio.h>
#include "core/base/alloc.h"
#include "core/base/log.h"
#include "lab/train/trainer.h"

static const char program[] = "ffprocams " FFP_VERSION ", commit " FFP_COMMIT;

bool ffp_trainer_path(char path[FFP_PATH_MAX], const Trainer *trainer, const char *name, FfpError *err) {
    return ffp_join_path(path, trainer->out, name) ||
           ffp_fail(err, FFP_ERROR_ARGUMENT, trainer->out, "path is too long");
}

void ffp_trainer_swap_ema(Trainer *trainer, FfpAdam *whole) {
    real *values = trainer->model->values;
    trainer->model->values = whole->ema;
    whole->ema = values;
}

// Fetches the weights from the device. Afterwards the thread works on the CPU.
static void download_state(Trainer *trainer) {
    if (!trainer->mirror) return;
    ffp_device_use(trainer->device);
    ffp_mirror_download(trainer->mirror, trainer->model, &trainer->adam);
    ffp_device_use(NULL);
}

bool ffp_trainer_gather(Trainer *trainer, bool average_only, FfpAdam *whole, FfpError *err) {
    *whole = (FfpAdam){0};
    download_state(trainer);
    return ffp_shard_gather_state(&trainer->share, &trainer->adam, average_only, whole, err);
}

bool ffp_trainer_write_weights(Trainer *trainer, FfpAdam *whole, FfpError *err) {
    char path[FFP_PATH_MAX], steps[32];
    if (!ffp_trainer_path(path, trainer, "weights.safetensors", err)) return false;
    snprintf(steps, sizeof steps, "%lld", (long long)whole->step);
    char *config = ffp_train_config_print(&trainer->config, err);
    if (!config) return false;
    const char *const metadata[] = {"trained_steps", steps,   "training", config,
                                    "program",       program, "origin",   trainer->origin};
    ffp_trainer_swap_ema(trainer, whole);
    const bool ok = ffp_model_write(trainer->model, path, false, metadata, 4, err);
    ffp_trainer_swap_ema(trainer, whole);
    ffp_free(config);
    return ok;
}

// Of captures, the weights that are written are the best so far (ffp_held_out_score), not the last.
static bool write_files(Trainer *trainer, FfpAdam *whole, FfpError *err) {
    char path[FFP_PATH_MAX];
    return ffp_trainer_path(path, trainer, "checkpoint.safetensors", err) &&
           ffp_checkpoint_write(path, trainer->model, whole, &trainer->config, trainer->origin, err) &&
           (trainer->captures || ffp_trainer_write_weights(trainer, whole, err));
}

bool ffp_trainer_save(Trainer *trainer, FfpError *err) {
    FfpAdam whole;
    const bool ok = ffp_trainer_gather(trainer, false, &whole, err) &&
                    (!ffp_trainer_is_first(trainer) || write_files(trainer, &whole, err));
    ffp_shard_state_free(&trainer->share, &whole);
    trainer->saved = ffp_seconds();
    return ok;
}
