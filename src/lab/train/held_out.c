// Captures that are held out of the training on the others: their score says which weights are kept, and when
// to stop.
#include <stdlib.h>
#include <string.h>
#include "core/base/log.h"
#include "lab/train/trainer.h"

bool ffp_held_out_open(Trainer *trainer, FfpError *err) {
    if (trainer->share.turn.count > 1)
        return ffp_fail(err, FFP_ERROR_UNSUPPORTED, NULL, "learning from captures requires a single process");
    trainer->captures = ffp_captures_open(&trainer->config, err);
    if (!trainer->captures) return false;
    ffp_note("%d captures to learn from, %d held out", ffp_captures_count(trainer->captures, false),
             ffp_captures_count(trainer->captures, true));
    return true;
}

bool ffp_held_out_resume(Trainer *trainer, FfpError *err) {
    char path[FFP_PATH_MAX];
    FfpHeldOut score;
    if (!ffp_trainer_path(path, trainer, "weights.safetensors", err)) return false;
    FfpModel *model = ffp_model_read(path, err);
    if (!model) return false;
    model->config.samples = trainer->config.model.samples;
    model->config.tokens = trainer->config.model.tokens;
    const char *step = NULL;
    for (int i = 0; i < model->metadata_count; i++)
        if (strcmp(model->metadata[2 * i], "trained_steps") == 0) step = model->metadata[2 * i + 1];
    const bool ok = ffp_captures_score(model, &trainer->config, trainer->captures, &score, err);
    trainer->best_step = step ? strtoll(step, NULL, 10) : 0;
    trainer->before = trainer->best = score.polished;
    trainer->scored = -1;
    ffp_model_free(model);
    return ok;
}

bool ffp_held_out_score(Trainer *trainer, FfpAdam *whole, int64_t step, FfpError *err) {
    FfpHeldOut score;
    ffp_trainer_swap_ema(trainer, whole);
    const bool ok = ffp_captures_score(trainer->model, &trainer->config, trainer->captures, &score, err);
    ffp_trainer_swap_ema(trainer, whole);
    if (!ok) return false;
    const bool first = trainer->best == 0, better = first || score.polished > trainer->best;
    if (!ffp_metrics_held_out(trainer, step, &score, better && !first, err)) return false;
    trainer->scored = step;
    if (first) trainer->before = score.polished;
    if (!better) return true;
    trainer->best = score.polished;
    trainer->best_step = step;
    return ffp_trainer_write_weights(trainer, whole, err);
}

// Looked at where there is a new score: what was learnt since the last one may be a gain.
bool ffp_held_out_is_over(const Trainer *trainer) {
    const int patience = trainer->config.patience;
    return trainer->captures && patience > 0 && trainer->scored == trainer->adam.step &&
           trainer->adam.step - trainer->best_step >= patience;
}

void ffp_held_out_tell(const Trainer *trainer) {
    ffp_note("held-out photographs: %.2f dB before, %.2f dB with the weights that were kept, those of step "
             "%lld",
             trainer->before, trainer->best, (long long)trainer->best_step);
}
