// The loss of one step: network forward, a few views rendered under black, white and an active pattern,
// everything back.
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/device.h"
#include "core/base/integer.h"
#include "core/base/log.h"
#include "core/base/rng.h"
#include "core/base/vec.h"
#include "engine/render/pass.h"
#include "lab/train/train.h"

const char *const ffp_loss_term_names[FFP_LOSS_TERMS] = {
    [FFP_TERM_L1] = "l1",
    [FFP_TERM_SSIM] = "ssim",
    [FFP_TERM_PERCEPTUAL] = "perceptual",
    [FFP_TERM_MASK] = "mask",
    [FFP_TERM_DEPTH] = "depth",
    [FFP_TERM_DISTORTION] = "distortion",
    [FFP_TERM_NORMAL_SMOOTH] = "normal_smooth",
    [FFP_TERM_ROUGHNESS_SMOOTH] = "roughness_smooth",
    [FFP_TERM_DIRECT_T] = "direct_t",
    [FFP_TERM_TRUTH_ALBEDO] = "truth_albedo",
    [FFP_TERM_TRUTH_NORMAL] = "truth_normal",
    [FFP_TERM_TRUTH_ROUGHNESS] = "truth_roughness",
};

const char *const ffp_step_phase_names[FFP_PHASES] = {
    [FFP_PHASE_FORWARD] = "forward",
    [FFP_PHASE_POLISH] = "polish",
    [FFP_PHASE_RASTERISE] = "rasterise",
    [FFP_PHASE_SHADE] = "shade",
    [FFP_PHASE_LOSS] = "loss",
    [FFP_PHASE_SHADE_BACKWARD] = "shade_backward",
    [FFP_PHASE_RASTERISE_BACKWARD] = "rasterise_backward",
    [FFP_PHASE_BACKWARD] = "backward",
};

struct FfpTrainStep {
    const FfpTrainConfig *config;
    const FfpPerceptual *perceptual;
    FfpRenderSettings settings;
    FfpRun *run;
    FfpProfile profile; // of the run, this step
    FfpViewPass *pass;
    FfpImage picture, target, grad; // of one view, remade when its size changes
    FfpGaussians grad_gaussians;
    real *grad_t, *true_t; // [Gaussians]; true_t on the CPU alone
};

FfpTrainStep *ffp_train_step_new(const FfpTrainConfig *config, const FfpPerceptual *perceptual) {
    FfpTrainStep *s = ffp_alloc(1, sizeof *s);
    s->config = config;
    s->perceptual = perceptual;
    s->settings = ffp_render_settings(ffp_model_is_paper_form(&config->model), config->model.samples);
    s->run = ffp_run_new(true);
    s->run->profile = &s->profile;
    s->run->recompute = config->recompute;
    s->run->looks_only = config->looks_only;
    s->pass = ffp_view_pass_new(&s->settings);
    return s;
}

static void free_pictures(FfpTrainStep *s) {
    ffp_image_free(&s->picture);
    ffp_image_free(&s->target);
    ffp_image_free(&s->grad);
}

void ffp_train_step_free(FfpTrainStep *s) {
    if (!s) return;
    free_pictures(s);
    ffp_gaussians_free(&s->grad_gaussians);
    ffp_memory_free(s->grad_t);
    ffp_free(s->true_t);
    ffp_view_pass_free(s->pass);
    ffp_run_free(s->run);
    ffp_free(s);
}

FfpRun *ffp_train_step_run(FfpTrainStep *s) {
    return s->run;
}

static void fit_pictures(FfpTrainStep *s, int width, int height) {
    if (s->picture.width == width && s->picture.height == height) return;
    free_pictures(s);
    s->picture = ffp_image_new(width, height, 3);
    s->target = ffp_image_new(width, height, 3);
    s->grad = ffp_image_new(width, height, 3);
}

static void encode_into(FfpImage *out, const FfpImage *linear) {
    ffp_memory_copy(out->data, linear->data, sizeof(real) * (size_t)linear->width * linear->height * 3);
    ffp_image_to_srgb(out);
}

// On a device the value is not there before ffp_losses_collect.
static void add(FfpLosses *losses, FfpLossTerm term, double value) {
    ffp_loss_add(&losses->term[term], 1, value);
}

// Shades the view drawn last under one pattern, adds the image terms and takes their gradients back.
static void supervise_pattern(FfpTrainStep *s, const FfpScene *scene, const FfpView *view, int pattern,
                              bool perceptual, real weight, FfpLosses *losses) {
    const FfpTrainConfig *c = s->config;
    const FfpCapture *capture = &scene->capture;
    const FfpSummed *light = pattern == capture->black ? NULL : &scene->patterns[pattern];
    double clock = ffp_seconds();
    ffp_view_pass_shade(s->pass, capture->intensity, light, &s->picture);
    losses->seconds[FFP_PHASE_SHADE] += ffp_seconds() - clock;
    clock = ffp_seconds();

    encode_into(&s->target, &view->images[pattern]);
    ffp_memory_zero(s->grad.data, sizeof(real) * (size_t)s->grad.width * s->grad.height * 3);
    add(losses, FFP_TERM_L1, ffp_l1_loss(&s->picture, &s->target, weight * (real)c->l1, &s->grad));
    add(losses, FFP_TERM_SSIM, ffp_ssim_loss(&s->picture, &s->target, weight * (real)c->ssim, &s->grad));
    if (perceptual)
        add(losses, FFP_TERM_PERCEPTUAL,
            ffp_perceptual_loss(s->perceptual, &s->picture, &s->target, weight * (real)c->perceptual,
                                &s->grad));
    losses->seconds[FFP_PHASE_LOSS] += ffp_seconds() - clock;
    clock = ffp_seconds();

    ffp_view_pass_shade_backward(s->pass, capture->intensity, light, &s->grad, NULL, NULL);
    losses->seconds[FFP_PHASE_SHADE_BACKWARD] += ffp_seconds() - clock;
}

// A G-buffer against the generator's map, where there is one.
static double truth_loss(const real *sum, const FfpGbuffer *g, const FfpView *view, const FfpImage *truth,
                         real weight, real *grad) {
    if (!truth->data || weight == 0) return 0;
    return ffp_truth_loss(sum, g->opacity, truth, &view->coverage, weight, grad);
}

// The terms that look at G-buffers.
static void supervise_gbuffer(FfpTrainStep *s, const FfpView *view, real weight, FfpLosses *losses) {
    const FfpTrainConfig *c = s->config;
    const FfpGbuffer *g = ffp_view_pass_gbuffer(s->pass);
    FfpGbuffer *d = ffp_view_pass_grad_gbuffer(s->pass);
    const int pixels = g->width * g->height;
    const real *mask = view->coverage.data;
    add(losses, FFP_TERM_MASK, ffp_mask_loss(g->opacity, mask, pixels, weight * (real)c->mask, d->opacity));
    if (view->depth.data)
        add(losses, FFP_TERM_DEPTH,
            ffp_depth_loss(g->depth, g->opacity, view->depth.data, pixels, weight * (real)c->depth, d->depth,
                           d->opacity));
    add(losses, FFP_TERM_DISTORTION,
        ffp_distortion_loss(g->distortion, pixels, weight * (real)c->distortion, d->distortion));
    add(losses, FFP_TERM_NORMAL_SMOOTH,
        ffp_normal_smooth_loss(g->normal, mask, g->width, g->height, weight * (real)c->normal_smooth,
                               d->normal));
    add(losses, FFP_TERM_ROUGHNESS_SMOOTH,
        ffp_roughness_loss(g->roughness, g->albedo, g->opacity, mask, g->width, g->height,
                           weight * (real)c->roughness_smooth, d->roughness, d->opacity));
    add(losses, FFP_TERM_TRUTH_ALBEDO,
        truth_loss(g->albedo, g, view, &view->albedo, weight * (real)c->truth_albedo, d->albedo));
    add(losses, FFP_TERM_TRUTH_NORMAL,
        truth_loss(g->normal, g, view, &view->normal, weight * (real)c->truth_normal, d->normal));
    add(losses, FFP_TERM_TRUTH_ROUGHNESS,
        truth_loss(g->roughness, g, view, &view->roughness, weight * (real)c->truth_roughness, d->roughness));
}

// One view: rasterised once, seen under black and, from their steps on, under white and a random lollipop
// (L_img of the paper, Sec. 3.6).
static void supervise_view(FfpTrainStep *s, const FfpScene *scene, const FfpGaussians *gaussians, int index,
                           int64_t step, FfpRng *rng, real weight, FfpLosses *losses) {
    const FfpTrainConfig *c = s->config;
    const FfpCapture *capture = &scene->capture;
    const FfpView *view = &capture->views[index];
    fit_pictures(s, view->camera.width, view->camera.height);
    double clock = ffp_seconds();
    ffp_view_pass_draw(s->pass, gaussians, &view->camera, &view->projector);
    losses->seconds[FFP_PHASE_RASTERISE] += ffp_seconds() - clock;

    int active;
    do active = (int)ffp_rng_below(rng, (uint32_t)capture->n_patterns);
    while (active == capture->black || active == capture->white);
    const bool perceptual = s->perceptual && c->perceptual > 0 && step >= c->perceptual_from;
    supervise_pattern(s, scene, view, capture->black, perceptual, weight, losses);
    if (step >= c->white_from) supervise_pattern(s, scene, view, capture->white, perceptual, weight, losses);
    if (step >= c->active_from) supervise_pattern(s, scene, view, active, perceptual, weight, losses);
    clock = ffp_seconds();
    supervise_gbuffer(s, view, weight, losses);
    losses->seconds[FFP_PHASE_LOSS] += ffp_seconds() - clock;
    clock = ffp_seconds();

    ffp_view_pass_backward(s->pass, &s->grad_gaussians);
    losses->seconds[FFP_PHASE_RASTERISE_BACKWARD] += ffp_seconds() - clock;
}

// `count` different numbers out of [first, first + total), at random; total up to FFP_TRAIN_VIEWS_MAX.
static void draw(FfpRng *rng, int first, int total, int count, int *out) {
    int all[FFP_TRAIN_VIEWS_MAX] = {0};
    for (int i = 0; i < total; i++) all[i] = first + i;
    for (int i = 0; i < count; i++) {
        const int j = i + (int)ffp_rng_below(rng, (uint32_t)(total - i));
        const int swap = all[i];
        all[i] = all[j];
        all[j] = swap;
        out[i] = all[i];
    }
}

// Mean |t - truth| over the foreground Gaussians of the input views whose pixel has a true depth, times the
// weight.
static double direct_loss(FfpTrainStep *s, const FfpScene *scene, real weight) {
    const FfpRun *run = s->run;
    if (scene->true_t)
        return ffp_distance_loss(run->t, scene->true_t, run->gaussians.count, weight, s->grad_t);
    ffp_scene_distances(s->true_t, scene, run->pixel, run->gaussians.count);
    return ffp_distance_loss(run->t, s->true_t, run->gaussians.count, weight, s->grad_t);
}

static void clear_gradients(FfpTrainStep *s) {
    const int64_t count = s->run->gaussians.count;
    if (s->grad_gaussians.count != count || !s->grad_t) {
        ffp_gaussians_free(&s->grad_gaussians);
        ffp_memory_free(s->grad_t);
        ffp_free(s->true_t);
        s->grad_gaussians = ffp_gaussians_new(count);
        s->grad_t = ffp_memory_new((size_t)count + 1, sizeof(real));
        s->true_t = ffp_device() ? NULL : ffp_alloc((size_t)count + 1, sizeof(real));
        return;
    }
    ffp_gaussians_clear(&s->grad_gaussians);
}

// Draws the views of a step with `gaussians`, the network's own or what a fit has made of them. Either way
// the gradient becomes that of the network's: a short fit is taken for a shift that does not depend on where
// it begins (first-order meta-learning, Finn et al. 2017, section 5.2).
static void supervise(FfpTrainStep *s, const FfpScene *scene, const FfpGaussians *gaussians, int64_t step,
                      FfpRng *rng, FfpLosses *losses) {
    const FfpTrainConfig *c = s->config;
    const int inputs = scene->inputs.n_views, targets = scene->capture.n_views - inputs;
    const int wanted = scene->targets_only ? 0 : c->supervised_inputs;
    const int drawn = ffp_smaller(wanted, inputs);
    const int novel = ffp_smaller(c->supervised_targets + c->supervised_inputs - wanted, targets);
    const int count = drawn + novel;
    int views[2 * FFP_TRAIN_VIEWS_MAX] = {0};
    draw(rng, 0, inputs, drawn, views);
    draw(rng, inputs, targets, novel, views + drawn);
    for (int i = 0; i < count; i++)
        supervise_view(s, scene, gaussians, views[i], step, rng, 1 / (real)count, losses);
}

static bool supervise_polished(FfpTrainStep *s, const FfpScene *scene, int64_t step, FfpRng *rng,
                               FfpLosses *losses, FfpError *err) {
    const double clock = ffp_seconds();
    FfpGaussians polished = ffp_gaussians_copy(&s->run->gaussians);
    const bool ok = ffp_scene_polish(&polished, s->config, &s->settings, scene, ffp_rng_u32(rng), err);
    losses->seconds[FFP_PHASE_POLISH] = ffp_seconds() - clock;
    if (ok) supervise(s, scene, &polished, step, rng, losses);
    ffp_gaussians_free(&polished);
    return ok;
}

static bool predict(FfpTrainStep *s, const FfpModel *model, const FfpScene *scene, FfpError *err) {
    if (ffp_device()) return ffp_model_forward_prepared(model, s->run, scene->prepared, err);
    return ffp_model_forward(model, s->run, &scene->inputs, &scene->start, &scene->context, scene->active,
                             err);
}

bool ffp_train_step_loss(FfpTrainStep *s, const FfpModel *model, const FfpScene *scene, int64_t draw,
                         FfpLosses *losses, real *grad, FfpError *err) {
    const FfpTrainConfig *c = s->config;
    const int64_t step = draw / c->batch;
    FfpRng rng = ffp_rng((uint64_t)c->seed, (uint64_t)draw);
    const bool polished = c->polish_share > 0 && ffp_rng_uniform(&rng) < c->polish_share;
    s->run->looks = polished ? 0 : FFP_LOOKS_MAX;
    *losses = (FfpLosses){0};
    s->profile = (FfpProfile){0};
    double clock = ffp_seconds();
    if (!predict(s, model, scene, err)) return false;
    losses->seconds[FFP_PHASE_FORWARD] = ffp_seconds() - clock;
    clear_gradients(s);
    ffp_losses_defer(); // on a device all values are waited for at once
    add(losses, FFP_TERM_DIRECT_T, direct_loss(s, scene, (real)c->direct_t));

    bool ok = true;
    if (polished)
        ok = supervise_polished(s, scene, step, &rng, losses, err);
    else
        supervise(s, scene, &s->run->gaussians, step, &rng, losses);
    ffp_losses_collect();
    if (!ok) return false;
    for (int i = 0; i < FFP_LOSS_TERMS; i++) losses->total += losses->term[i];
    clock = ffp_seconds();
    ffp_model_backward(model, s->run, &s->grad_gaussians, s->grad_t, grad);
    losses->seconds[FFP_PHASE_BACKWARD] = ffp_seconds() - clock;
    losses->network = s->profile;
    return true;
}
