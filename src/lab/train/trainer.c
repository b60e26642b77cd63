// The training loop.
#include "lab/train/trainer.h"
#include "core/base/arena.h"
#include "core/base/call.h"
#include "core/base/file.h"
#include "core/base/log.h"
#include "engine/network/shipped.h"

// On rank 0, which has the average of all weights.
static bool validate_here(Trainer *trainer, FfpAdam *whole, int64_t step, FfpError *err) {
    char name[64], path[FFP_PATH_MAX];
    snprintf(name, sizeof name, "validation_%06lld.png", (long long)step);
    if (!ffp_trainer_path(path, trainer, name, err)) return false;
    FfpValidation v;
    ffp_trainer_swap_ema(trainer, whole);
    const bool ok = ffp_validate(trainer->model, &trainer->config, path, &v, err);
    ffp_trainer_swap_ema(trainer, whole);
    if (!ok) return false;
    return ffp_metrics_validation(trainer, step, &v, err);
}

// Of the averaged weights of a step: a validation, or with captures the score of those held out. By all ranks
// together.
static bool validate(Trainer *trainer, int64_t step, FfpError *err) {
    FfpAdam whole;
    bool ok = ffp_trainer_gather(trainer, true, &whole, err);
    if (ok && ffp_trainer_is_first(trainer))
        ok = trainer->captures ? ffp_held_out_score(trainer, &whole, step, err)
                               : validate_here(trainer, &whole, step, err);
    ffp_shard_state_free(&trainer->share, &whole);
    return ok;
}

// A step that failed has changed nothing: what was learnt before it is kept. All ranks stay until it is
// written, since the first that ends with an error may end the others.
static void save_partial(Trainer *trainer) {
    FfpError why = {0};
    double nothing = 0;
    ffp_note("failed at step %lld: writing a checkpoint", (long long)trainer->adam.step);
    if (!ffp_trainer_save(trainer, &why)) ffp_warning("%s", why.text);
    if (!ffp_shard_sum(&trainer->share, &nothing, 1, &why)) ffp_warning("%s", why.text);
}

static bool is_due(int64_t done, int every) {
    return every > 0 && done % every == 0;
}

// Saves and reports after a step.
static bool report(Trainer *trainer, int64_t done, bool save_due, FfpError *err) {
    const FfpTrainConfig *config = &trainer->config;
    const bool last = done == config->steps;
    if ((last || save_due || is_due(done, config->checkpoint_steps)) && !ffp_trainer_save(trainer, err))
        return false;
    return !config->validate_every || !(last || is_due(done, config->validate_every)) ||
           validate(trainer, done, err);
}

// The last weights have their score too, however the run ended.
static bool end_held_out(Trainer *trainer, FfpError *err) {
    const int64_t step = trainer->adam.step;
    if (trainer->scored != step && !validate(trainer, step, err)) return false;
    ffp_held_out_tell(trainer);
    return true;
}

static bool run(Trainer *trainer, int64_t stop_at, FfpError *err) {
    const FfpTrainConfig *config = &trainer->config;
    const int64_t first = trainer->adam.step;
    bool stopped = false;
    while (trainer->adam.step < config->steps && !stopped) {
        bool save_due = false;
        const FfpStepOutcome outcome = ffp_trainer_step(trainer, trainer->adam.step, &save_due, err);
        if (outcome == FFP_STEP_FAILED && trainer->adam.step > first) save_partial(trainer);
        if (outcome == FFP_STEP_FAILED || outcome == FFP_STEP_BROKEN) return false;
        if (outcome == FFP_STEP_LEARNT && !report(trainer, trainer->adam.step, save_due, err)) return false;
        stopped = trainer->stop || trainer->adam.step == stop_at;
        if (trainer->adam.step < config->steps && ffp_held_out_is_over(trainer)) {
            ffp_note("no improvement for %d steps: done", config->patience);
            return ffp_trainer_save(trainer, err) && end_held_out(trainer, err);
        }
    }
    trainer->stop = stopped;
    if (stopped && trainer->adam.step < config->steps) {
        if (ffp_trainer_is_first(trainer))
            ffp_note("stopped at step %lld: writing a checkpoint", (long long)trainer->adam.step);
        if (!ffp_trainer_save(trainer, err)) return false;
    }
    return !trainer->captures || end_held_out(trainer, err);
}

static bool open_scenes(Trainer *trainer, int64_t stop_at, FfpError *err) {
    const FfpTrainConfig *config = &trainer->config;
    const int64_t first = trainer->adam.step;
    const int64_t end = stop_at > first && stop_at < config->steps ? stop_at : config->steps;
    const FfpSceneOrigin origin = {config->scenes[0] ? &trainer->folder : NULL, trainer->captures,
                                   &trainer->stock, trainer->rooms};
    trainer->scenes = ffp_stream_new(config, &origin, trainer->share.turn, first, end, &trainer->stop, err);
    return trainer->scenes != NULL;
}

static bool begin(Trainer *trainer, const FfpTrainRun *options, FfpError *err) {
    if (trainer->captures &&
        !(options->resume ? ffp_held_out_resume(trainer, err) : validate(trainer, 0, err)))
        return false;
    trainer->started = trainer->saved = ffp_seconds();
    return open_scenes(trainer, options->stop_at, err);
}

// Fine-tuning goes on from the shipped weights where none are named.
static bool settle_initial(FfpTrainRun *options, char shipped[FFP_PATH_MAX], FfpError *err) {
    if (!options->captures) return true;
    if (options->resume)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "captures",
                        "a resumed run uses those of its checkpoint and accepts no others");
    if (options->initial) return true;
    options->initial = shipped;
    return ffp_find_weights(shipped, err);
}

// Threads that make scenes read the trainer until they have ended, which is later than this frame where the
// call is left: it lies in the call's memory.
bool ffp_train_run(const FfpTrainRun *asked, FfpError *err) {
    char shipped[FFP_PATH_MAX];
    FfpTrainRun settled = *asked;
    const FfpTrainRun *options = &settled;
    if (!settle_initial(&settled, shipped, err)) return false;
    Trainer *trainer = ffp_alloc(1, sizeof *trainer);
    ffp_cancel_hold_off(true); // it ends with a checkpoint
    const bool ok = ffp_trainer_open(trainer, options, err) && begin(trainer, options, err) &&
                    run(trainer, options->stop_at, err);
    ffp_trainer_close(trainer);
    ffp_free(trainer);
    return ok;
}
