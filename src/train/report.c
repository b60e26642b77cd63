// What a training run tells: metrics as lines of JSON, and notes.
#include <math.h>
#include <stdlib.h>
#include <jansson.h>
#include "base/log.h"
#include "train/trainer.h"

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
    return json_pack("{so so so so so so so so so so so so}", "l1", number(l->l1), "ssim", number(l->ssim),
                     "perceptual", number(l->perceptual), "mask", number(l->mask), "depth", number(l->depth),
                     "distortion", number(l->distortion), "normal_smooth", number(l->normal_smooth),
                     "roughness_smooth", number(l->roughness_smooth), "direct_t", number(l->direct_t),
                     "truth_albedo", number(l->truth_albedo), "truth_normal", number(l->truth_normal),
                     "truth_roughness", number(l->truth_roughness));
}

static json_t *network_seconds(const FfpProfileTimes *t) {
    return json_pack("{sf sf sf sf sf sf}", "tokenise", t->tokenise, "scan", t->scan, "attention",
                     t->attention, "products", t->products, "other", t->other, "heads", t->heads);
}

static json_t *seconds_of(const FfpLosses *l, double scene_s, double step_s) {
    return json_pack("{sf sf sf sf so sf sf sf sf sf sf so}", "step", step_s, "scene", scene_s, "forward",
                     l->forward_s, "polish", l->polish_s, "network_forward",
                     network_seconds(&l->network.forward), "rasterise", l->rasterise_s, "shade", l->shade_s,
                     "loss", l->loss_s, "shade_backward", l->shade_backward_s, "rasterise_backward",
                     l->rasterise_backward_s, "backward", l->backward_s, "network_backward",
                     network_seconds(&l->network.backward));
}

bool ffp_tell_step(const Trainer *trainer, int64_t step, const FfpLosses *l, double norm, bool skipped,
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
             (long long)step, (long long)trainer->config.steps, l->total, l->l1, l->ssim, l->direct_t,
             l->mask, norm, skipped ? " skipped" : "", rate, step_s, elapsed);
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

bool ffp_tell_validation(const Trainer *trainer, int64_t step, const FfpValidation *v, FfpError *err) {
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

bool ffp_tell_held_out(const Trainer *trainer, int64_t step, const FfpHeldOut *score, bool gain,
                       FfpError *err) {
    json_t *line = json_pack("{sI so so si}", "step", (json_int_t)step, "held_out", number(score->alone),
                             "polished_held_out", number(score->polished), "photographs", score->photographs);
    if (!write_metrics(trainer, line, err)) return false;
    ffp_note("held-out photographs at step %lld: %.2f dB, polished %.2f dB%s", (long long)step, score->alone,
             score->polished, gain ? ", the best so far" : "");
    return true;
}
