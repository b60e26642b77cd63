// The training loop.
#include "train/trainer.h"

#include <math.h>
#include <string.h>
#include "base/arena.h"
#include "base/call.h"
#include "base/device.h"
#include "base/file.h"
#include "base/log.h"
#include "capture/fields.h"

static const char program[] = "ffprocams " FFP_VERSION ", commit " FFP_COMMIT;

bool ffp_trainer_path(char path[FFP_PATH_MAX], const Trainer *trainer, const char *name, FfpError *err) {
    return ffp_join_path(path, trainer->out, name) ||
           ffp_fail(err, FFP_ERROR_ARGUMENT, trainer->out, "path is too long");
}

static bool is_first(const Trainer *trainer) {
    return trainer->share.turn.rank == 0;
}

void ffp_trainer_swap_ema(Trainer *trainer, FfpAdam *whole) {
    real *values = trainer->model->values;
    trainer->model->values = whole->ema;
    whole->ema = values;
}

// What the device has made of the weights. Afterwards the thread works on the CPU.
static void come_home(Trainer *trainer) {
    if (!trainer->mirror) return;
    ffp_device_use(trainer->device);
    ffp_mirror_download(trainer->mirror, trainer->model, &trainer->adam);
    ffp_device_use(NULL);
}

// On rank 0, which has the average of all weights.
static bool validate_here(Trainer *trainer, FfpAdam *whole, int64_t step, FfpError *err) {
    char name[64], path[FFP_PATH_MAX];
    snprintf(name, sizeof name, "validation_%06lld.png", (long long)step);
    if (!ffp_trainer_path(path, trainer, name, err)) return false;
    FfpValidation v;
    ffp_trainer_swap_ema(trainer, whole);
    const int64_t last = step > 0 ? step - 1 : 0;
    const bool ok = ffp_validate(trainer->model, &trainer->config, ffp_resolution_at(&trainer->config, last),
                                 path, &v, err);
    ffp_trainer_swap_ema(trainer, whole);
    if (!ok) return false;
    return ffp_tell_validation(trainer, step, &v, err);
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

bool ffp_trainer_validate(Trainer *trainer, int64_t step, FfpError *err) {
    FfpAdam whole = {0};
    come_home(trainer);
    bool ok = ffp_share_whole(&trainer->share, &trainer->adam, true, &whole, err);
    if (ok && is_first(trainer))
        ok = trainer->captures ? ffp_held_out_score(trainer, &whole, step, err)
                               : validate_here(trainer, &whole, step, err);
    ffp_share_whole_free(&trainer->share, &whole);
    return ok;
}

// Of captures, the weights that are written are the best so far (ffp_held_out_score), not the last.
static bool write_files(Trainer *trainer, FfpAdam *whole, FfpError *err) {
    char path[FFP_PATH_MAX];
    return ffp_trainer_path(path, trainer, "checkpoint.safetensors", err) &&
           ffp_checkpoint_write(path, trainer->model, whole, &trainer->config, trainer->origin, err) &&
           (trainer->captures || ffp_trainer_write_weights(trainer, whole, err));
}

// By all ranks together.
static bool save(Trainer *trainer, FfpError *err) {
    FfpAdam whole = {0};
    come_home(trainer);
    const bool ok = ffp_share_whole(&trainer->share, &trainer->adam, false, &whole, err) &&
                    (!is_first(trainer) || write_files(trainer, &whole, err));
    ffp_share_whole_free(&trainer->share, &whole);
    trainer->saved = ffp_seconds();
    return ok;
}

// --- One step. ---

// What a rank has to say about a step, added up over all of them.
typedef struct Tally {
    double failed, missing, stop; // ranks: whose step failed; that lack a scene; that are to stop
    double save;                  // rank 0 finds that a checkpoint is due
    double squares;               // of the gradient
    double terms[FFP_LOSS_TERMS];
} Tally;
enum { TALLY = sizeof(Tally) / sizeof(double) };

static bool is_to_stop(Trainer *trainer) {
    if (ffp_cancelled()) trainer->stop = true;
    return trainer->stop;
}

// All of FfpLosses are doubles, the terms first.
static void add_losses(FfpLosses *sum, const FfpLosses *more) {
    double *a = (double *)sum;
    const double *b = (const double *)more;
    for (size_t i = 0; i < sizeof *sum / sizeof *a; i++) a[i] += b[i];
}

// Adds the gradient of one draw, on what the thread works on.
static bool add_draw(Trainer *trainer, const FfpScene *scene, bool fresh, int64_t draw, bool last,
                     FfpLosses *sum, FfpError *err) {
    const FfpTrainConfig *config = &trainer->config;
    FfpMirror *mirror = trainer->mirror;
    FfpLosses losses;
    FfpRun *run = ffp_stepper_run(trainer->stepper);
    if (mirror) scene = ffp_mirror_scene(mirror, ffp_scene_slot(config, draw), fresh, scene);
    run->ready = last && trainer->share.ranks ? ffp_share_ready : NULL;
    run->ready_user = &trainer->share;
    if (!ffp_step_loss(trainer->stepper, mirror ? &mirror->model : trainer->model, scene, draw, &losses,
                       trainer->grad, err))
        return false;
    add_losses(sum, &losses);
    return true;
}

// This rank's draws of a step. *missing: it was to stop, and not all are there.
static bool add_draws(Trainer *trainer, int64_t step, FfpLosses *sum, double *scene_s, bool *missing,
                      FfpError *err) {
    const FfpTurn turn = trainer->share.turn;
    const int64_t first = step * trainer->config.batch, end = first + trainer->config.batch;
    for (int64_t draw = first + turn.rank; draw < end; draw += turn.count) {
        const double begin = ffp_seconds();
        const FfpScene *scene = NULL;
        bool fresh;
        if (!is_to_stop(trainer) && !ffp_stream_scene(trainer->scenes, draw, &scene, &fresh, err))
            return false;
        *scene_s += ffp_seconds() - begin;
        *missing = !scene;
        if (*missing) return true;
        ffp_device_use(trainer->device);
        const bool ok = add_draw(trainer, scene, fresh, draw, draw + turn.count >= end, sum, err);
        ffp_device_use(NULL);
        if (!ok) return false;
    }
    return true;
}

// Where the weights and their state are that steps change.
static FfpModel *model_at_work(Trainer *trainer) {
    return trainer->mirror ? &trainer->mirror->model : trainer->model;
}

static FfpAdam *adam_at_work(Trainer *trainer) {
    return trainer->mirror ? &trainer->mirror->adam : &trainer->adam;
}

// Sums of gradients and of what each rank says. A rank whose step failed takes part, so that nobody waits.
static bool agree(Trainer *trainer, Tally *tally, FfpError *err) {
    const double begin = ffp_seconds();
    ffp_device_use(trainer->device);
    bool ok = ffp_share_finish(&trainer->share, err);
    if (ok) tally->squares = ffp_adam_squares(adam_at_work(trainer), trainer->grad);
    ffp_device_use(NULL);
    ok = ok && ffp_share_sum(&trainer->share, (double *)tally, TALLY, err);
    if (tally->stop > 0) trainer->stop = true;
    trainer->wait_s = ffp_seconds() - begin;
    return ok;
}

static bool learn(Trainer *trainer, double norm, bool *skipped, FfpError *err) {
    FfpModel *model = model_at_work(trainer);
    FfpAdam *adam = adam_at_work(trainer);
    ffp_device_use(trainer->device);
    ffp_adam_move_all(adam, model, trainer->grad, &trainer->config, norm, skipped);
    const double begin = ffp_seconds();
    const bool ok = *skipped || ffp_share_weights(&trainer->share, model->values, err);
    trainer->gather_s = ffp_seconds() - begin;
    ffp_device_use(NULL);
    trainer->adam.step = adam->step;
    return ok;
}

static bool is_save_due(const Trainer *trainer) {
    return is_first(trainer) && ffp_seconds() - trainer->saved > 60.0 * trainer->config.checkpoint_minutes;
}

// The losses' means over the draws of all ranks.
static void take_means(FfpLosses *losses, const Tally *tally, int batch) {
    for (int i = 0; i < FFP_LOSS_TERMS; i++) ((double *)losses)[i] = tally->terms[i] / batch;
}

typedef enum Outcome {
    LEARNT,
    STOPPED,
    FAILED,
    BROKEN
} Outcome; // BROKEN: the ranks are out of touch, or cannot tell of it

// STOPPED, FAILED: nothing has changed. *save_due: a checkpoint is.
static Outcome one_step(Trainer *trainer, int64_t step, bool *save_due, FfpError *err) {
    const double begin = ffp_seconds();
    FfpLosses losses = {0};
    Tally tally = {0};
    double scene_s = 0;
    bool missing = false, skipped = false;
    ffp_device_use(trainer->device);
    ffp_memory_zero(trainer->grad, (size_t)trainer->model->count * sizeof(real));
    ffp_share_begin(&trainer->share, trainer->grad);
    ffp_device_use(NULL);
    const bool made = add_draws(trainer, step, &losses, &scene_s, &missing, err);
    tally.failed = !made, tally.missing = missing, tally.stop = is_to_stop(trainer);
    tally.save = is_save_due(trainer);
    memcpy(tally.terms, &losses, sizeof tally.terms);
    FfpError why = {0};
    if (!agree(trainer, &tally, &why)) {
        ffp_fail(err, why.code, NULL, "%s", why.text);
        return BROKEN;
    }
    if (tally.failed > 0 && made) ffp_fail(err, FFP_ERROR_IO, NULL, "the step failed on another rank");
    if (tally.failed > 0) return FAILED;
    if (tally.missing > 0) return STOPPED;
    const double norm = sqrt(tally.squares) / trainer->config.batch;
    if (!learn(trainer, norm, &skipped, err)) return BROKEN;
    *save_due = tally.save > 0;
    if (!is_first(trainer)) return LEARNT;
    if (skipped) ffp_warning("step %lld skipped: gradient norm %g", (long long)step, norm);
    take_means(&losses, &tally, trainer->config.batch);
    if (step % trainer->config.log_every == 0 &&
        !ffp_tell_step(trainer, step, &losses, norm, skipped, scene_s, ffp_seconds() - begin - scene_s, err))
        return BROKEN;
    return LEARNT;
}

// A step that failed has changed nothing: what was learnt before it is kept. All ranks stay until it is
// written, since the first that ends with an error may end the others.
static void save_what_there_is(Trainer *trainer) {
    FfpError why = {0};
    double nothing = 0;
    ffp_note("failed at step %lld: writing a checkpoint", (long long)trainer->adam.step);
    if (!save(trainer, &why)) ffp_warning("%s", why.text);
    if (!ffp_share_sum(&trainer->share, &nothing, 1, &why)) ffp_warning("%s", why.text);
}

static bool is_due(int64_t done, int every) {
    return every > 0 && done % every == 0;
}

// What follows a step.
static bool report(Trainer *trainer, int64_t done, bool save_due, FfpError *err) {
    const FfpTrainConfig *config = &trainer->config;
    const bool last = done == config->steps;
    if ((last || save_due || is_due(done, config->checkpoint_steps)) && !save(trainer, err)) return false;
    return !config->validate_every || !(last || is_due(done, config->validate_every)) ||
           ffp_trainer_validate(trainer, done, err);
}

static bool run(Trainer *trainer, int64_t stop_at, FfpError *err) {
    const FfpTrainConfig *config = &trainer->config;
    const int64_t first = trainer->adam.step;
    bool stopped = false;
    while (trainer->adam.step < config->steps && !stopped) {
        bool save_due = false;
        const Outcome outcome = one_step(trainer, trainer->adam.step, &save_due, err);
        if (outcome == FAILED && trainer->adam.step > first) save_what_there_is(trainer);
        if (outcome == FAILED || outcome == BROKEN) return false;
        if (outcome == LEARNT && !report(trainer, trainer->adam.step, save_due, err)) return false;
        stopped = trainer->stop || trainer->adam.step == stop_at;
        if (trainer->adam.step < config->steps && ffp_held_out_is_over(trainer)) {
            ffp_note("no gain for %d steps: done", config->patience);
            return save(trainer, err) && ffp_held_out_end(trainer, err);
        }
    }
    trainer->stop = stopped;
    if (stopped && trainer->adam.step < config->steps) {
        if (is_first(trainer))
            ffp_note("stopped at step %lld: writing a checkpoint", (long long)trainer->adam.step);
        if (!save(trainer, err)) return false;
    }
    return !trainer->captures || ffp_held_out_end(trainer, err);
}

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

// The weights to start from, of their own configuration but for what is no matter of weights, and for
// context_inputs, which begin at zero where the file has none.
static FfpModel *read_initial(const char *path, const FfpTrainConfig *config, FfpError *err) {
    FfpModel *model = ffp_model_read(path, err);
    if (!model) return NULL;
    model->config.samples = config->model.samples;
    model->config.tokens = config->model.tokens;
    if (model->config.context_inputs || !config->model.context_inputs) return model;
    FfpModelConfig wider = model->config;
    wider.context_inputs = true;
    FfpModel *out = ffp_model_new(&wider, (uint64_t)config->seed, err);
    if (out) {
        ffp_model_take_over(out, model);
        out->metadata = model->metadata, out->metadata_count = model->metadata_count;
        model->metadata = NULL, model->metadata_count = 0;
    }
    ffp_model_free(model);
    return out;
}

static bool take_captures(FfpTrainConfig *config, const char *path, FfpError *err) {
    if (strlen(path) >= sizeof config->captures)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, path, "path is too long");
    if (!ffp_is_utf8(path))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, path,
                        "path is not UTF-8: the checkpoint could not say what is learnt from");
    snprintf(config->captures, sizeof config->captures, "%s", path);
    return true;
}

// The model and its configuration: from the checkpoint, from given weights, or new.
static bool open_model(Trainer *trainer, const FfpTrainRun *options, FfpError *err) {
    FfpTrainConfig *config = &trainer->config;
    char path[FFP_PATH_MAX];
    if (options->resume) {
        if (options->config || options->initial) {
            ffp_fail(err, FFP_ERROR_ARGUMENT, NULL,
                     "a resumed run takes its configuration and weights from the checkpoint alone");
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
                        "a run is here already: resume it, or choose another folder to start afresh");
    trainer->metrics = ffp_open_to_grow(path, true, err);
    if (trainer->metrics) ffp_own_file(trainer->metrics);
    return trainer->metrics != NULL;
}

static bool open_scenes(Trainer *trainer, int64_t stop_at, FfpError *err) {
    const FfpTrainConfig *config = &trainer->config;
    const int64_t first = trainer->adam.step;
    const int64_t end = stop_at > first && stop_at < config->steps ? stop_at : config->steps;
    trainer->scenes = ffp_stream_new(config, config->scenes[0] ? &trainer->folder : NULL, trainer->captures,
                                     trainer->share.turn, first, end, &trainer->stop, err);
    return trainer->scenes != NULL;
}

// What steps need, where they are made.
static void open_device(Trainer *trainer) {
    trainer->device = ffp_device_offered();
    ffp_device_use(trainer->device);
    if (trainer->device) trainer->mirror = ffp_mirror_new(trainer->model, &trainer->adam, &trainer->config);
    trainer->stepper = ffp_stepper_new(&trainer->config, trainer->perceptual);
    trainer->grad = ffp_memory_new((size_t)trainer->model->count, sizeof(real));
    ffp_device_use(NULL);
}

static void close_device(Trainer *trainer) {
    ffp_device_use(trainer->device);
    ffp_mirror_free(trainer->mirror, &trainer->config);
    ffp_stepper_free(trainer->stepper);
    ffp_perceptual_free(trainer->perceptual);
    ffp_memory_free(trainer->grad);
    ffp_device_use(NULL);
}

// What training on a device lacks.
static bool check_device(const FfpTrainConfig *config, FfpError *err) {
    if (!ffp_device_offered() || config->warmup_geometry == 0) return true;
    return ffp_fail(err, FFP_ERROR_UNSUPPORTED, "warmup_geometry",
                    "is not on the device: 0, or train on the CPU");
}

// This rank's part of the work and of the optimiser's state.
static bool open_share(Trainer *trainer, FfpError *err) {
    FfpShare *share = &trainer->share;
    ffp_share_open(share, trainer->model->count);
    if (!ffp_share_check(share, &trainer->config, trainer->adam.step, err)) return false;
    if (share->ranks) ffp_adam_keep(&trainer->adam, ffp_share_first(share), ffp_share_count(share));
    return true;
}

// The metrics file is opened after all that can be wrong: a folder that holds one counts as a run.
static bool open_trainer(Trainer *trainer, const FfpTrainRun *options, FfpError *err) {
    trainer->out = options->out;
    if (!open_model(trainer, options, err) || !check_device(&trainer->config, err)) return false;
    if (options->perceptual && !(trainer->perceptual = ffp_perceptual_read(options->perceptual, err)))
        return false;
    if (!options->perceptual && trainer->config.perceptual > 0)
        ffp_note("no perceptual weights given: the perceptual term is off");
    const char *scenes = trainer->config.scenes;
    if (scenes[0] && !ffp_scene_folder_open(&trainer->folder, scenes, err)) return false;
    if (!open_share(trainer, err)) return false;
    if (trainer->config.captures[0] && !ffp_held_out_open(trainer, err)) return false;
    if (is_first(trainer) && !open_metrics(trainer, options->resume, err)) return false;
    open_device(trainer);
    if (trainer->captures && !ffp_held_out_begin(trainer, options->resume, err)) return false;
    trainer->started = trainer->saved = ffp_seconds();
    return open_scenes(trainer, options->stop_at, err);
}

static void close_trainer(Trainer *trainer) {
    ffp_stream_free(trainer->scenes);
    ffp_scene_folder_close(&trainer->folder);
    ffp_captures_close(trainer->captures);
    close_device(trainer);
    ffp_share_close(&trainer->share);
    ffp_adam_free(&trainer->adam);
    ffp_model_free(trainer->model);
    if (trainer->metrics) ffp_close_file(trainer->metrics);
}

// Threads that make scenes read the trainer until they have ended, which is later than this frame where the
// call is left: it lies in the call's memory.
bool ffp_train_run(const FfpTrainRun *options, FfpError *err) {
    Trainer *trainer = ffp_alloc(1, sizeof *trainer);
    ffp_cancel_hold_off(true); // it ends with a checkpoint
    const bool ok = open_trainer(trainer, options, err) && run(trainer, options->stop_at, err);
    close_trainer(trainer);
    ffp_free(trainer);
    return ok;
}
