// Whole steps of `small` on a made-up scene: encoder, training step and its parts, reconstruction.
#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/log.h"
#include "core/base/memory.h"
#include "engine/network/layout.h"
#include "engine/refine/refine.h"
#include "engine/render/pass.h"
#include "lab/bench/bench.h"
#include "lab/train/train.h"

enum { REPEATS = 5 };

// --- Useful operations of the network, a multiply-add being two. ---

typedef struct Work {
    double encoder, heads; // one forward pass
} Work;

static double mamba_work(const FfpWidths *w, double rows) {
    const double projections = 2 * rows * w->dim * (w->projected + w->inner);
    const double direction = 4 * rows * w->inner * w->state + 2 * rows * w->chunk * (w->inner + w->state) +
                             2 * rows * w->convolved * FFP_CONV_TAPS;
    return projections + 2 * direction;
}

static double transformer_work(const FfpWidths *w, double rows) {
    return 2 * rows * w->dim * w->dim * (4 + 2 * FFP_MLP_RATIO) + 4 * rows * rows * w->dim;
}

static Work network_work(const FfpModelConfig *config, double rows, double gaussians) {
    const FfpWidths w = ffp_widths(config);
    const double pixels = config->patch * config->patch, channels = ffp_input_channels(config);
    const double joined = config->pixel_features + channels, hidden = config->pixel_hidden;
    Work work = {.encoder = 2 * rows * w.dim * pixels * channels};
    for (const char *module = config->modules; *module; module++)
        work.encoder += *module == 'M' ? mamba_work(&w, rows) : transformer_work(&w, rows);
    const double mlp =
        joined * hidden + hidden * hidden * (FFP_HIDDEN_LAYERS - 1) + hidden * ffp_head_numbers(config);
    work.heads = 2 * gaussians * (w.dim * config->pixel_features + mlp);
    return work;
}

// --- The steps. ---

typedef struct Steps {
    FfpTrainConfig config;
    FfpScene scene;
    FfpModel *model;
    FfpTrainStep *stepper;
    real *grad;
    FfpAdam adam;
} Steps;

static void add(FfpBenchTable *table, const char *name, const char *shape, double seconds, double work,
                double memory) {
    FfpBenchRow row = {.name = name, .ms = 1e3 * seconds, .work = work, .peak_mb = memory};
    snprintf(row.shape, sizeof row.shape, "%s", shape);
    ffp_bench_add(table, &row);
}

static double encoder_seconds(const FfpProfileTimes *t) {
    return t->tokenise + t->scan + t->attention + t->products + t->other;
}

static double network_seconds(const FfpLosses *l) {
    return l->seconds[FFP_PHASE_FORWARD] + l->seconds[FFP_PHASE_BACKWARD];
}

static bool one_step(Steps *s, FfpLosses *losses, FfpError *err) {
    bool skipped;
    memset(s->grad, 0, (size_t)s->model->count * sizeof(real));
    if (!ffp_train_step_loss(s->stepper, s->model, &s->scene, 1000, losses, s->grad, err)) return false;
    ffp_adam_update(&s->adam, s->model, s->grad, &s->config, &skipped);
    return true;
}

// The step whose network part was fastest, after one to warm up.
static bool training(Steps *s, FfpBenchTable *table, FfpError *err) {
    FfpLosses best = {0}, losses;
    double took = 0;
    ffp_memory_mark();
    for (int i = 0; i <= REPEATS; i++) {
        const double begin = omp_get_wtime();
        if (!one_step(s, &losses, err)) return false;
        const double now = omp_get_wtime() - begin;
        if (i > 0 && (i == 1 || network_seconds(&losses) < network_seconds(&best))) {
            best = losses;
            took = now;
        }
    }
    const double memory = fmax(ffp_memory_peak(), 0) / (1 << 20);
    const int tokens = s->scene.start.views * s->scene.start.width * s->scene.start.height /
                       (s->config.model.patch * s->config.model.patch);
    const double gaussians = (double)ffp_train_step_run(s->stepper)->gaussians.count;
    const Work work = network_work(&s->config.model, tokens, gaussians);
    const FfpProfileTimes *f = &best.network.forward, *b = &best.network.backward;
    char shape[64];
    snprintf(shape, sizeof shape, "%d tokens, width %d, %.24s", tokens, s->config.model.dim,
             s->config.model.modules);
    add(table, "encoder_forward", shape, encoder_seconds(f), work.encoder, 0);
    snprintf(shape, sizeof shape, "%d x %d, %d views supervised, %.0f splats", s->config.resolution,
             s->config.resolution, s->config.supervised_inputs + s->config.supervised_targets, gaussians);
    add(table, "train_step", shape, took, 0, memory);
    add(table, "  network", "forward and backward, with the heads", network_seconds(&best),
        3 * (work.encoder + work.heads), 0);
    add(table, "  products", "forward and backward", f->products + b->products, 0, 0);
    add(table, "  attention", "forward and backward", f->attention + b->attention, 0, 0);
    add(table, "  scan", "forward and backward", f->scan + b->scan, 0, 0);
    add(table, "  heads", "forward and backward", f->heads + b->heads, 0, 0);
    add(table, "  tokenise, norms, other", "forward and backward",
        f->tokenise + f->other + b->tokenise + b->other, 0, 0);
    add(table, "  rasterise", "all views, with their shadow maps", best.seconds[FFP_PHASE_RASTERISE], 0, 0);
    add(table, "  rasterise back", "all views", best.seconds[FFP_PHASE_RASTERISE_BACKWARD], 0, 0);
    add(table, "  shade", "all pictures, forward and backward",
        best.seconds[FFP_PHASE_SHADE] + best.seconds[FFP_PHASE_SHADE_BACKWARD], 0, 0);
    add(table, "  losses", "all pictures", best.seconds[FFP_PHASE_LOSS], 0, 0);
    return true;
}

// Least seconds of fitting a prediction to its photographs; it says whether it worked.
static bool polish(Steps *s, const FfpRun *run, double *seconds, FfpError *err) {
    const FfpRenderSettings drawing = ffp_render_defaults();
    FfpGaussians gaussians = ffp_gaussians_copy(&run->gaussians);
    const double begin = omp_get_wtime();
    const bool ok = ffp_scene_polish(&gaussians, &s->config, &drawing, &s->scene, 1, err);
    *seconds = fmin(*seconds, omp_get_wtime() - begin);
    ffp_gaussians_free(&gaussians);
    return ok;
}

// From a capture in memory to a picture: matching, network, one view relit.
static bool reconstruction(Steps *s, FfpBenchTable *table, FfpError *err) {
    const FfpMatchSettings settings = ffp_match_defaults();
    const FfpRenderSettings drawing = ffp_render_defaults();
    const FfpView *view = &s->scene.capture.views[0];
    FfpRun *run = ffp_run_new(false);
    double best[3] = {1e30, 1e30, 1e30}, total = 1e30, polished = 1e30;
    bool ok = true;
    ffp_memory_mark();
    for (int i = 0; i <= REPEATS && ok; i++) {
        FfpInitialisation start;
        const double begin = omp_get_wtime();
        if (!(ok = ffp_initialisation_new(&start, &s->scene.inputs, &s->scene.active, 1, &settings, err)))
            break;
        const double matched = omp_get_wtime();
        ok = ffp_model_forward(s->model, run, &s->scene.inputs, &start, NULL, s->scene.active, err);
        const double passed = omp_get_wtime();
        if (ok) {
            FfpImage picture =
                ffp_render_view(&run->gaussians, &view->camera, &view->projector, s->scene.capture.intensity,
                                &s->scene.patterns[s->scene.active], &drawing);
            ffp_image_free(&picture);
        }
        const double end = omp_get_wtime();
        ffp_initialisation_free(&start);
        ok = ok && polish(s, run, &polished, err);
        if (i == 0 || end - begin >= total) continue;
        total = end - begin;
        best[0] = matched - begin, best[1] = passed - matched, best[2] = end - passed;
    }
    const double memory = fmax(ffp_memory_peak(), 0) / (1 << 20);
    ffp_run_free(run);
    if (!ok) return false;
    add(table, "reconstruct_and_render", "8 views of 128 x 128, one picture", total, 0, memory);
    add(table, "  matching", "the classical initialisation", best[0], 0, 0);
    add(table, "  network", "forward, with the heads", best[1], 0, 0);
    add(table, "  picture", "rasterised, mapped, shaded", best[2], 0, 0);
    char steps[64];
    snprintf(steps, sizeof steps, "%d steps; not in the sum above", FFP_POLISH_DEFAULT_STEPS);
    add(table, "polish", steps, polished, 0, 0);
    return true;
}

bool ffp_bench_steps(FfpBenchTable *table, FfpError *err) {
    Steps s = {.config = ffp_train_defaults()};
    s.config.resolution = 128;
    s.config.polish_steps = FFP_POLISH_DEFAULT_STEPS;
    ffp_model_preset(&s.config.model, "small");
    if (!ffp_scene_open(&s.scene, &s.config, NULL, "train", 0, err)) return false;
    s.model = ffp_model_new(&s.config.model, 1, err);
    bool ok = s.model != NULL;
    if (ok) {
        s.stepper = ffp_train_step_new(&s.config, NULL);
        s.adam = ffp_adam_new(s.model);
        s.grad = ffp_alloc((size_t)s.model->count, sizeof *s.grad);
        ok = training(&s, table, err) && reconstruction(&s, table, err);
        ffp_train_step_free(s.stepper);
        ffp_adam_free(&s.adam);
        ffp_free(s.grad);
    }
    ffp_model_free(s.model);
    ffp_scene_close(&s.scene);
    return ok;
}
