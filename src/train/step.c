// The loss of one step: network forward, a few views rendered under black, white and an active pattern,
// everything back.
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "base/arena.h"
#include "base/device.h"
#include "base/log.h"
#include "base/rng.h"
#include "base/vec.h"
#include "render/pass.h"
#include "train/table.h"
#include "train/train.h"

struct FfpStepper {
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

FfpStepper *ffp_stepper_new(const FfpTrainConfig *config, const FfpPerceptual *perceptual) {
    FfpStepper *s = ffp_alloc(1, sizeof *s);
    s->config = config;
    s->perceptual = perceptual;
    s->settings = ffp_render_settings(ffp_model_is_paper_form(&config->model), config->model.samples);
    s->run = ffp_run_new(true);
    s->run->profile = &s->profile;
    s->run->recompute = config->recompute;
    s->pass = ffp_view_pass_new(&s->settings);
    return s;
}

static void free_pictures(FfpStepper *s) {
    ffp_image_free(&s->picture);
    ffp_image_free(&s->target);
    ffp_image_free(&s->grad);
}

void ffp_stepper_free(FfpStepper *s) {
    if (!s) return;
    free_pictures(s);
    ffp_gaussians_free(&s->grad_gaussians);
    ffp_memory_free(s->grad_t);
    ffp_free(s->true_t);
    ffp_view_pass_free(s->pass);
    ffp_run_free(s->run);
    ffp_free(s);
}

FfpRun *ffp_stepper_run(FfpStepper *s) {
    return s->run;
}

static void fit_pictures(FfpStepper *s, int width, int height) {
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

// Shades the view drawn last under one pattern, adds the image terms and takes their gradients back.
static void supervise_pattern(FfpStepper *s, const FfpScene *scene, const FfpView *view, int pattern,
                              bool perceptual, real weight, FfpLosses *losses) {
    const FfpTrainConfig *c = s->config;
    const FfpCapture *capture = &scene->capture;
    const FfpSummed *light = pattern == capture->black ? NULL : &scene->patterns[pattern];
    double clock = ffp_seconds();
    ffp_view_pass_shade(s->pass, capture->intensity, light, &s->picture);
    losses->shade_s += ffp_seconds() - clock, clock = ffp_seconds();

    encode_into(&s->target, &view->images[pattern]);
    ffp_memory_zero(s->grad.data, sizeof(real) * (size_t)s->grad.width * s->grad.height * 3);
    ffp_loss_add(&losses->l1, 1, ffp_l1_loss(&s->picture, &s->target, weight * (real)c->l1, &s->grad));
    ffp_loss_add(&losses->ssim, 1, ffp_ssim_loss(&s->picture, &s->target, weight * (real)c->ssim, &s->grad));
    if (perceptual)
        ffp_loss_add(&losses->perceptual, 1,
                     ffp_perceptual_loss(s->perceptual, &s->picture, &s->target, weight * (real)c->perceptual,
                                         &s->grad));
    losses->loss_s += ffp_seconds() - clock, clock = ffp_seconds();

    ffp_view_pass_shade_backward(s->pass, capture->intensity, light, &s->grad, NULL, NULL);
    losses->shade_backward_s += ffp_seconds() - clock;
}

// weight * mean over foreground values of |sum - O truth|, O held constant: a G-buffer against the
// generator's map.
static double truth_loss(const real *sum, const real *opacity, const FfpImage *truth,
                         const FfpImage *coverage, real weight, real *grad) {
    if (!truth->data || weight == 0) return 0;
    const int pixels = truth->width * truth->height, channels = truth->channels;
    if (ffp_device())
        return ffp_device()->train->truth_loss(sum, opacity, truth->data, coverage->data, pixels, channels,
                                               weight, grad);
    double total = 0;
    int64_t count = 0;
    for (int p = 0; p < pixels; p++) count += coverage->data[p] > 0.5F;
    const real step = weight / (real)(count > 0 ? count * channels : 1);
    for (int p = 0; p < pixels; p++) {
        if (coverage->data[p] <= 0.5F) continue;
        for (int k = 0; k < channels; k++) {
            const int i = p * channels + k;
            const real difference = sum[i] - opacity[p] * truth->data[i];
            total += fabsf(difference);
            grad[i] += difference > 0 ? step : difference < 0 ? -step : 0;
        }
    }
    return total * step;
}

// The terms that look at G-buffers.
static void supervise_gbuffer(FfpStepper *s, const FfpView *view, real weight, FfpLosses *losses) {
    const FfpTrainConfig *c = s->config;
    const FfpGbuffer *g = ffp_view_pass_gbuffer(s->pass);
    FfpGbuffer *d = ffp_view_pass_grad_gbuffer(s->pass);
    const int pixels = g->width * g->height;
    const real *mask = view->coverage.data;
    ffp_loss_add(&losses->mask, 1,
                 ffp_mask_loss(g->opacity, mask, pixels, weight * (real)c->mask, d->opacity));
    if (view->depth.data)
        ffp_loss_add(&losses->depth, 1,
                     ffp_depth_loss(g->depth, g->opacity, view->depth.data, pixels, weight * (real)c->depth,
                                    d->depth, d->opacity));
    ffp_loss_add(&losses->distortion, 1,
                 ffp_distortion_loss(g->distortion, pixels, weight * (real)c->distortion, d->distortion));
    ffp_loss_add(&losses->normal_smooth, 1,
                 ffp_normal_smooth_loss(g->normal, mask, g->width, g->height, weight * (real)c->normal_smooth,
                                        d->normal));
    ffp_loss_add(&losses->roughness_smooth, 1,
                 ffp_roughness_loss(g->roughness, g->albedo, g->opacity, mask, g->width, g->height,
                                    weight * (real)c->roughness_smooth, d->roughness, d->opacity));
    ffp_loss_add(&losses->truth_albedo, 1,
                 truth_loss(g->albedo, g->opacity, &view->albedo, &view->coverage,
                            weight * (real)c->truth_albedo, d->albedo));
    ffp_loss_add(&losses->truth_normal, 1,
                 truth_loss(g->normal, g->opacity, &view->normal, &view->coverage,
                            weight * (real)c->truth_normal, d->normal));
    ffp_loss_add(&losses->truth_roughness, 1,
                 truth_loss(g->roughness, g->opacity, &view->roughness, &view->coverage,
                            weight * (real)c->truth_roughness, d->roughness));
}

// One view: rasterised once, seen under black, white and a random lollipop.
static void supervise_view(FfpStepper *s, const FfpScene *scene, const FfpGaussians *gaussians, int index,
                           int64_t step, FfpRng *rng, real weight, FfpLosses *losses) {
    const FfpTrainConfig *c = s->config;
    const FfpCapture *capture = &scene->capture;
    const FfpView *view = &capture->views[index];
    fit_pictures(s, view->camera.width, view->camera.height);
    double clock = ffp_seconds();
    ffp_view_pass_draw(s->pass, gaussians, &view->camera, &view->projector);
    losses->rasterise_s += ffp_seconds() - clock;

    int active;
    do active = (int)ffp_rng_below(rng, (uint32_t)capture->n_patterns);
    while (active == capture->black || active == capture->white);
    const bool perceptual = s->perceptual && c->perceptual > 0 && step >= c->perceptual_from;
    supervise_pattern(s, scene, view, capture->black, false, weight, losses);
    if (step >= c->white_from) supervise_pattern(s, scene, view, capture->white, false, weight, losses);
    if (step >= c->active_from) supervise_pattern(s, scene, view, active, perceptual, weight, losses);
    clock = ffp_seconds();
    supervise_gbuffer(s, view, weight, losses);
    losses->loss_s += ffp_seconds() - clock, clock = ffp_seconds();

    ffp_view_pass_backward(s->pass, &s->grad_gaussians);
    losses->rasterise_backward_s += ffp_seconds() - clock;
}

// `count` different numbers out of [first, first + total), at random; total up to FFP_TRAIN_VIEWS_MAX.
static void draw(FfpRng *rng, int first, int total, int count, int *out) {
    int all[FFP_TRAIN_VIEWS_MAX] = {0};
    for (int i = 0; i < total; i++) all[i] = first + i;
    for (int i = 0; i < count; i++) {
        const int j = i + (int)ffp_rng_below(rng, (uint32_t)(total - i));
        const int swap = all[i];
        all[i] = all[j], all[j] = swap;
        out[i] = all[i];
    }
}

static double distance_loss(const real *t, const real *truth, int64_t count, real weight, real *grad) {
    if (ffp_device()) return ffp_device()->train->distance_loss(t, truth, count, weight, grad);
    double total = 0;
    int64_t known = 0;
    for (int64_t i = 0; i < count; i++) {
        grad[i] = 0;
        // The analyzer lets the device come and go between two lines; only with one there is no truth here.
        if (truth[i] <= 0) continue; // NOLINT(clang-analyzer-core.NullDereference)
        const real error = t[i] - truth[i];
        total += fabsf(error);
        grad[i] = error > 0 ? 1 : -1;
        known++;
    }
    if (known == 0) return 0;
    for (int64_t i = 0; i < count; i++) grad[i] *= weight / (real)known;
    return total * weight / (double)known;
}

// Mean |t - truth| over the foreground Gaussians of the input views whose pixel has a true depth, times the
// weight. An absolute error, because matching's errors are outliers.
static double direct_loss(FfpStepper *s, const FfpScene *scene, real weight) {
    const FfpRun *run = s->run;
    if (scene->true_t) return distance_loss(run->t, scene->true_t, run->gaussians.count, weight, s->grad_t);
    ffp_scene_distances(s->true_t, scene, run->pixel, run->gaussians.count);
    return distance_loss(run->t, s->true_t, run->gaussians.count, weight, s->grad_t);
}

// During the geometry warm-up: opacity against the pixel's mask, as cross-entropy, without the rasteriser.
static double direct_opacity_loss(FfpStepper *s, const FfpScene *scene) {
    const FfpRun *run = s->run;
    const int64_t count = run->gaussians.count;
    const int pixels = scene->start.width * scene->start.height;
    double total = 0;
    for (int64_t i = 0; i < count; i++) {
        const real mask = scene->inputs.views[run->pixel[i] / pixels].coverage.data[run->pixel[i] % pixels];
        total += ffp_mask_loss(&run->gaussians.opacity[i], &mask, 1, (real)s->config->mask / (real)count,
                               &s->grad_gaussians.opacity[i]);
    }
    return total;
}

static void clear_gradients(FfpStepper *s) {
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
static void supervise(FfpStepper *s, const FfpScene *scene, const FfpGaussians *gaussians, int64_t step,
                      FfpRng *rng, FfpLosses *losses) {
    const FfpTrainConfig *c = s->config;
    const int inputs = scene->inputs.n_views, targets = scene->capture.n_views - inputs;
    const int drawn = c->supervised_inputs < inputs ? c->supervised_inputs : inputs;
    const int novel = c->supervised_targets < targets ? c->supervised_targets : targets;
    const int count = drawn + novel;
    int views[2 * FFP_TRAIN_VIEWS_MAX] = {0};
    draw(rng, 0, inputs, drawn, views);
    draw(rng, inputs, targets, novel, views + drawn);
    for (int i = 0; i < count; i++)
        supervise_view(s, scene, gaussians, views[i], step, rng, 1 / (real)count, losses);
}

static bool supervise_polished(FfpStepper *s, const FfpScene *scene, int64_t step, FfpRng *rng,
                               FfpLosses *losses, FfpError *err) {
    const double clock = ffp_seconds();
    FfpGaussians polished = ffp_gaussians_copy(&s->run->gaussians);
    const bool ok = ffp_scene_polish(&polished, s->config, &s->settings, scene, ffp_rng_u32(rng), err);
    losses->polish_s = ffp_seconds() - clock;
    if (ok) supervise(s, scene, &polished, step, rng, losses);
    ffp_gaussians_free(&polished);
    return ok;
}

static bool supervise_scene(FfpStepper *s, const FfpScene *scene, int64_t draw, FfpLosses *losses,
                            FfpError *err) {
    const FfpTrainConfig *c = s->config;
    const int64_t step = draw / c->batch;
    if (step < c->warmup_geometry) {
        losses->mask = direct_opacity_loss(s, scene);
        return true;
    }
    FfpRng rng = ffp_rng((uint64_t)c->seed, (uint64_t)draw);
    if (c->polish_share > 0 && ffp_rng_uniform(&rng) < c->polish_share)
        return supervise_polished(s, scene, step, &rng, losses, err);
    supervise(s, scene, &s->run->gaussians, step, &rng, losses);
    return true;
}

static bool predict(FfpStepper *s, const FfpModel *model, const FfpScene *scene, FfpError *err) {
    if (ffp_device()) return ffp_model_forward_prepared(model, s->run, scene->prepared, err);
    return ffp_model_forward(model, s->run, &scene->inputs, &scene->start, &scene->context, scene->active,
                             err);
}

bool ffp_step_loss(FfpStepper *s, const FfpModel *model, const FfpScene *scene, int64_t draw,
                   FfpLosses *losses, real *grad, FfpError *err) {
    const FfpTrainConfig *c = s->config;
    *losses = (FfpLosses){0};
    s->profile = (FfpProfile){0};
    double clock = ffp_seconds();
    if (!predict(s, model, scene, err)) return false;
    losses->forward_s = ffp_seconds() - clock;
    clear_gradients(s);
    ffp_losses_late(); // on a device all values are waited for at once
    ffp_loss_add(&losses->direct_t, 1, direct_loss(s, scene, (real)c->direct_t));

    const bool ok = supervise_scene(s, scene, draw, losses, err);
    ffp_losses_settle();
    if (!ok) return false;
    losses->total = losses->l1 + losses->ssim + losses->perceptual + losses->mask + losses->depth +
                    losses->distortion + losses->normal_smooth + losses->roughness_smooth + losses->direct_t +
                    losses->truth_albedo + losses->truth_normal + losses->truth_roughness;
    clock = ffp_seconds();
    ffp_model_backward(model, s->run, &s->grad_gaussians, s->grad_t, grad);
    losses->backward_s = ffp_seconds() - clock;
    losses->network = s->profile;
    return true;
}
