// One step of a training run, by all ranks together.
#include <math.h>
#include <string.h>
#include "core/base/call.h"
#include "core/base/device.h"
#include "core/base/log.h"
#include "lab/train/trainer.h"

// A rank's figures for a step, in double, added up over all of them.
enum {
    FAILED,  // ranks whose step failed,
    MISSING, // that lack a scene,
    STOP,    // that are to stop
    SAVE,    // rank 0 finds that a checkpoint is due
    SQUARES, // of the gradient
    TOTAL,   // of the losses,
    TERM,    // and each of them
    TALLY = TERM + FFP_LOSS_TERMS
};

static bool is_to_stop(Trainer *trainer) {
    if (ffp_cancelled()) trainer->stop = true;
    return trainer->stop;
}

static void add_times(FfpProfileTimes *sum, const FfpProfileTimes *more) {
    sum->tokenise += more->tokenise;
    sum->scan += more->scan;
    sum->attention += more->attention;
    sum->products += more->products;
    sum->other += more->other;
    sum->heads += more->heads;
}

static void add_losses(FfpLosses *sum, const FfpLosses *more) {
    for (int i = 0; i < FFP_LOSS_TERMS; i++) sum->term[i] += more->term[i];
    sum->total += more->total;
    for (int i = 0; i < FFP_PHASES; i++) sum->seconds[i] += more->seconds[i];
    add_times(&sum->network.forward, &more->network.forward);
    add_times(&sum->network.backward, &more->network.backward);
}

// Adds the gradient of one draw, on what the thread works on.
static bool add_draw(Trainer *trainer, const FfpScene *scene, bool fresh, int64_t draw, bool last,
                     FfpLosses *sum, FfpError *err) {
    const FfpTrainConfig *config = &trainer->config;
    FfpMirror *mirror = trainer->mirror;
    FfpLosses losses;
    FfpRun *run = ffp_train_step_run(trainer->stepper);
    if (mirror) scene = ffp_mirror_scene(mirror, ffp_scene_slot(config, draw), fresh, scene);
    run->ready = last && trainer->share.ranks ? ffp_shard_reduce_ready : NULL;
    run->ready_user = &trainer->share;
    if (!ffp_train_step_loss(trainer->stepper, mirror ? &mirror->model : trainer->model, scene, draw, &losses,
                             trainer->grad, err))
        return false;
    add_losses(sum, &losses);
    return true;
}

// This rank's draws of a step. *missing: it was told to stop before all of them were ready.
static bool add_draws(Trainer *trainer, int64_t step, FfpLosses *sum, double *scene_s, bool *missing,
                      FfpError *err) {
    const FfpRank turn = trainer->share.turn;
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
static bool agree(Trainer *trainer, double tally[TALLY], FfpError *err) {
    const double begin = ffp_seconds();
    ffp_device_use(trainer->device);
    bool ok = ffp_shard_reduce_finish(&trainer->share, err);
    if (ok) tally[SQUARES] = ffp_adam_squares(adam_at_work(trainer), trainer->grad);
    ffp_device_use(NULL);
    ok = ok && ffp_shard_sum(&trainer->share, tally, TALLY, err);
    if (tally[STOP] > 0) trainer->stop = true;
    trainer->wait_s = ffp_seconds() - begin;
    return ok;
}

static bool learn(Trainer *trainer, double norm, bool *skipped, FfpError *err) {
    FfpModel *model = model_at_work(trainer);
    FfpAdam *adam = adam_at_work(trainer);
    ffp_device_use(trainer->device);
    ffp_adam_move_all(adam, model, trainer->grad, &trainer->config, norm, skipped);
    const double begin = ffp_seconds();
    const bool ok = *skipped || ffp_shard_gather_weights(&trainer->share, model->values, err);
    trainer->gather_s = ffp_seconds() - begin;
    ffp_device_use(NULL);
    trainer->adam.step = adam->step;
    return ok;
}

static bool is_save_due(const Trainer *trainer) {
    return ffp_trainer_is_first(trainer) &&
           ffp_seconds() - trainer->saved > 60.0 * trainer->config.checkpoint_minutes;
}

// This rank's figures for its draws. Where some are missing it was to stop.
static void count(Trainer *trainer, double tally[TALLY], const FfpLosses *losses, bool made, bool missing) {
    tally[FAILED] = !made;
    tally[MISSING] = missing;
    tally[STOP] = is_to_stop(trainer);
    tally[SAVE] = is_save_due(trainer);
    tally[TOTAL] = losses->total;
    memcpy(tally + TERM, losses->term, sizeof losses->term);
}

// The losses' means over the draws of all ranks.
static void take_means(FfpLosses *losses, const double tally[TALLY], int batch) {
    losses->total = tally[TOTAL] / batch;
    for (int i = 0; i < FFP_LOSS_TERMS; i++) losses->term[i] = tally[TERM + i] / batch;
}

static void clear_gradient(Trainer *trainer) {
    ffp_device_use(trainer->device);
    ffp_memory_zero(trainer->grad, (size_t)trainer->model->count * sizeof(real));
    ffp_shard_reduce_begin(&trainer->share, trainer->grad);
    ffp_device_use(NULL);
}

FfpStepOutcome ffp_trainer_step(Trainer *trainer, int64_t step, bool *save_due, FfpError *err) {
    const double begin = ffp_seconds();
    FfpLosses losses = {0};
    double tally[TALLY] = {0}, scene_s = 0;
    bool missing = false, skipped = false;
    clear_gradient(trainer);
    const bool made = add_draws(trainer, step, &losses, &scene_s, &missing, err);
    count(trainer, tally, &losses, made, missing);
    FfpError why = {0};
    if (!agree(trainer, tally, &why)) {
        ffp_fail(err, why.code, NULL, "%s", why.text);
        return FFP_STEP_BROKEN;
    }
    if (tally[FAILED] > 0 && made) ffp_fail(err, FFP_ERROR_IO, NULL, "the step failed on another rank");
    if (tally[FAILED] > 0) return FFP_STEP_FAILED;
    if (tally[MISSING] > 0) return FFP_STEP_STOPPED;
    const double norm = sqrt(tally[SQUARES]) / trainer->config.batch;
    if (!learn(trainer, norm, &skipped, err)) return FFP_STEP_BROKEN;
    *save_due = tally[SAVE] > 0;
    if (!ffp_trainer_is_first(trainer)) return FFP_STEP_LEARNT;
    if (skipped) ffp_warning("step %lld skipped: gradient norm %g", (long long)step, norm);
    if (step % trainer->config.log_every != 0) return FFP_STEP_LEARNT;
    take_means(&losses, tally, trainer->config.batch);
    const double step_s = ffp_seconds() - begin - scene_s;
    return ffp_metrics_step(trainer, step, &losses, norm, skipped, scene_s, step_s, err) ? FFP_STEP_LEARNT
                                                                                         : FFP_STEP_BROKEN;
}
