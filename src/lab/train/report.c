// Reports of a training run: metrics as lines of JSON, and notes.
#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include "core/base/log.h"
#include "lab/train/trainer.h"

// Takes the line.
static bool write_metrics(const Trainer *trainer, json_t *line, FfpError *err) {
    char *text = json_dumps(line, JSON_COMPACT | JSON_PRESERVE_ORDER | JSON_REAL_PRECISION(6));
    const bool ok = text && fprintf(trainer->metrics, "%s\n", text) > 0 && fflush(trainer->metrics) == 0;
    free(text);
    json_decref(line);
    return ok || ffp_fail(err, FFP_ERROR_IO, trainer->out, "cannot write metrics.jsonl");
}

// null where it is none, as in a step that is skipped: JSON has no other word for it.
static json_t *number(double value) {
    return isfinite(value) ? json_real(value) : json_null();
}

static json_t *terms_of(const FfpLosses *l) {
    json_t *terms = json_object();
    for (int i = 0; i < FFP_LOSS_TERMS; i++)
        json_object_set_new(terms, ffp_loss_term_names[i], number(l->term[i]));
    return terms;
}

static json_t *network_seconds(const FfpProfileTimes *t) {
    return json_pack("{sf sf sf sf sf sf}", "tokenise", t->tokenise, "scan", t->scan, "attention",
                     t->attention, "products", t->products, "other", t->other, "heads", t->heads);
}

static json_t *seconds_of(const FfpLosses *l, double scene_s, double step_s) {
    json_t *seconds = json_pack("{sf sf}", "step", step_s, "scene", scene_s);
    for (int i = 0; i < FFP_PHASES; i++)
        json_object_set_new(seconds, ffp_step_phase_names[i], json_real(l->seconds[i]));
    json_object_set_new(seconds, "network_forward", network_seconds(&l->network.forward));
    json_object_set_new(seconds, "network_backward", network_seconds(&l->network.backward));
    return seconds;
}

bool ffp_metrics_step(const Trainer *trainer, int64_t step, const FfpLosses *l, double norm, bool skipped,
                      double scene_s, double step_s, FfpError *err) {
    const double rate = ffp_learning_rate(&trainer->config, step);
    json_t *seconds = seconds_of(l, scene_s, step_s);
    if (trainer->share.ranks) {
        json_object_set_new(seconds, "wait", json_real(trainer->wait_s));
        json_object_set_new(seconds, "gather", json_real(trainer->gather_s));
    }
    json_t *line = json_pack("{sI so so so sf sb so}", "step", (json_int_t)step, "loss", number(l->total),
                             "terms", terms_of(l), "gradient_norm", number(norm), "learning_rate", rate,
                             "skipped", (int)skipped, "seconds", seconds);
    if (!write_metrics(trainer, line, err)) return false;
    const double elapsed = ffp_seconds() - trainer->started;
    ffp_note("step %lld/%lld loss %.4f (l1 %.4f ssim %.4f t %.4f mask %.4f) norm %.2f%s rate %.2g, %.2f s a "
             "step, %.0f s",
             (long long)step, (long long)trainer->config.steps, l->total, l->term[FFP_TERM_L1],
             l->term[FFP_TERM_SSIM], l->term[FFP_TERM_DIRECT_T], l->term[FFP_TERM_MASK], norm,
             skipped ? " skipped" : "", rate, step_s, elapsed);
    return true;
}

static json_t *figures_of(const FfpValidation *v, int64_t step, bool with_free) {
    json_t *line = json_pack(
        "{sI so so so so so so so}", "step", (json_int_t)step, "validation_rendering", number(v->rendering),
        "validation_novel_pose", number(v->novel_pose), "polished_rendering", number(v->polished_rendering),
        "polished_novel_pose", number(v->polished_novel_pose), "start_rendering", number(v->start_rendering),
        "start_novel_pose", number(v->start_novel_pose), "depth_median_percent", number(v->depth_median));
    if (!with_free) return line;
    json_object_set_new(line, "free_rendering", number(v->free_rendering));
    json_object_set_new(line, "free_novel_pose", number(v->free_novel_pose));
    json_object_set_new(line, "polished_free_rendering", number(v->polished_free_rendering));
    json_object_set_new(line, "polished_free_novel_pose", number(v->polished_free_novel_pose));
    return line;
}

bool ffp_metrics_validation(const Trainer *trainer, int64_t step, const FfpValidation *v, FfpError *err) {
    const bool with_free = trainer->config.free_share > 0;
    if (!write_metrics(trainer, figures_of(v, step, with_free), err)) return false;
    ffp_note("validation at step %lld: rendering %.2f dB (polished %.2f, start %.2f), novel pose %.2f dB "
             "(polished %.2f, start %.2f), depth %.2f %%",
             (long long)step, v->rendering, v->polished_rendering, v->start_rendering, v->novel_pose,
             v->polished_novel_pose, v->start_novel_pose, v->depth_median);
    if (with_free)
        ffp_note("free rigs: rendering %.2f dB (polished %.2f), novel pose %.2f dB (polished %.2f)",
                 v->free_rendering, v->polished_free_rendering, v->free_novel_pose,
                 v->polished_free_novel_pose);
    return true;
}

bool ffp_metrics_held_out(const Trainer *trainer, int64_t step, const FfpHeldOut *score, bool gain,
                          FfpError *err) {
    json_t *line = json_pack("{sI so so si}", "step", (json_int_t)step, "held_out", number(score->alone),
                             "polished_held_out", number(score->polished), "photographs", score->photographs);
    if (!write_metrics(trainer, line, err)) return false;
    ffp_note("held-out photographs at step %lld: %.2f dB, polished %.2f dB%s", (long long)step, score->alone,
             score->polished, gain ? ", the best so far" : "");
    return true;
}
