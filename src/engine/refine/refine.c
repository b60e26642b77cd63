// The fit: rounds over all views, each view a step, until steps, seconds or patience end.
#include "engine/refine/refine.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/call.h"
#include "core/base/device.h"
#include "core/base/log.h"
#include "core/base/rng.h"
#include "engine/loss/loss.h"
#include "engine/refine/fit.h"
#include "engine/refine/table.h"

FfpRefineSettings ffp_refine_defaults(void) {
    return (FfpRefineSettings){
        .render = ffp_render_defaults(),
        .rates = {.rate = {[FFP_CENTRE] = 0.02F,
                           [FFP_SCALE] = 0.01F,
                           [FFP_ROTATION] = 0.005F,
                           [FFP_OPACITY] = 0.02F,
                           [FFP_ALBEDO] = 0.02F,
                           [FFP_ROUGHNESS] = 0.0025F,
                           [FFP_AMBIENT] = 0.02F,
                           [FFP_SCATTERED] = 0.002F},
                  .pull = {[FFP_CENTRE] = 2,
                           [FFP_SCALE] = 2,
                           [FFP_ROTATION] = 2,
                           [FFP_OPACITY] = 2,
                           [FFP_ALBEDO] = 0.4F,
                           [FFP_ROUGHNESS] = 2,
                           [FFP_AMBIENT] = 0.4F,
                           [FFP_SCATTERED] = 0.4F},
                  .shared_roughness = 0.05F},
        .decay = 0.1,
        .centre_decay = 0.1,
        .beta1 = 0.9F,
        .beta2 = 0.99F,
        .epsilon = 1e-12F,
        .l1 = 0.8F,
        .ssim = 0.2F,
        .mask = 0.1F,
        .roughness_smooth = 0.002F,
        .normal_smooth = 0.005F,
        .smooth = 0.05F,
        .measure = true,
        .seed = 1,
    };
}

// Rates chosen on scenes of the validation split (docs/lab/notebook/fit-optimiser.md).
FfpRefineSettings ffp_polish_defaults(int64_t steps) {
    FfpRefineSettings s = ffp_refine_defaults();
    const real faster[FFP_ATTRIBUTES] = {
        [FFP_CENTRE] = 7.2F, [FFP_SCALE] = 9.6F,     [FFP_ROTATION] = 1.8F, [FFP_OPACITY] = 19.2F,
        [FFP_ALBEDO] = 2.4F, [FFP_ROUGHNESS] = 4.8F, [FFP_AMBIENT] = 4.8F,  [FFP_SCATTERED] = 6};
    for (int a = 0; a < FFP_ATTRIBUTES; a++) {
        s.rates.rate[a] *= faster[a];
        s.rates.pull[a] /= 20; // so few steps do not stray far
    }
    // Otherwise its noise takes from the albedo (docs/lab/notebook/ambient-light.md).
    s.rates.pull[FFP_SCATTERED] = 5;
    s.rates.shared_roughness *= 4;
    s.square = 10;
    s.mask = 0.3F;
    s.smooth = 0;
    s.decay = s.centre_decay = 0.2;
    s.mean = 0.3;
    s.mean_late = 3;
    s.beta1 = 0.5F; // for so few steps
    s.beta2 = 0.9F;
    s.coupled = true;
    s.distortion = 0.3F;
    s.hold = 0.01F;
    s.pairs = true;
    s.shadow_looks = 4;
    s.steps = steps;
    s.measure = false;
    return s;
}

#define LOSSES_MOST 3 // rounds in a row below the first: a fit that only does harm ends

typedef struct Fit { // one run of ffp_refine
    const FfpCapture *capture;
    const FfpRefineSettings *settings;
    FfpPhotoLoss *viewer;
    FfpParameters parameters;
    FfpGaussians gaussians, grad[2]; // decoded, and gradients: the second's is that of a pair
    FfpGaussianAdam adam_state;
    FfpGaussians best;
    double best_psnr, first_psnr; // of rounds
    int64_t best_round, rounds;   // complete ones so far; which was the best, from 1
    int lost;                     // rounds in a row below the first
    bool grown;                   // after the last step: no look has seen what there is now
    FfpGaussians mean;            // of the numbers after each of the last `averaged` steps
    int64_t averaged;
    int *order;         // [n_views] of the round
    FfpFitLoss *losses; // [n_views] of its steps
    FfpRng rng;
    FfpTask progress;
    double started;
    int64_t step;
} Fit;

static void shuffle(Fit *fit) {
    for (int i = fit->capture->n_views - 1; i > 0; i--) {
        const int j = (int)ffp_rng_below(&fit->rng, (uint32_t)i + 1), swap = fit->order[i];
        fit->order[i] = fit->order[j];
        fit->order[j] = swap;
    }
}

static void clear(FfpGaussians *g) {
    if (ffp_device()) {
        ffp_device()->refine->clear(g);
        return;
    }
    for (int a = 0; a < FFP_ATTRIBUTES; a++) {
        const FfpAttribute x = ffp_attribute(g, a);
        ffp_memory_zero(x.data, (size_t)g->count * (size_t)x.width * sizeof(real));
    }
}

static void copy(FfpGaussians *to, const FfpGaussians *from) {
    if (to->count != from->count) {
        ffp_gaussians_free(to);
        *to = ffp_gaussians_new(from->count);
    }
    ffp_gaussians_take_notes(to, from);
    for (int a = 0; a < FFP_ATTRIBUTES; a++) {
        const FfpAttribute x = ffp_attribute(from, a);
        ffp_memory_copy(ffp_attribute(to, a).data, x.data,
                        (size_t)from->count * (size_t)x.width * sizeof(real));
    }
}

typedef struct Round { // means over the views
    double total, psnr;
} Round;

static double share_spent(const Fit *fit) {
    return ffp_share_spent(fit->step, fit->settings->steps, fit->started, fit->settings->seconds);
}

static int64_t steps_left(const Fit *fit) {
    return fit->settings->steps > 0 ? fit->settings->steps - fit->step : INT64_MAX;
}

static bool over(const Fit *fit) {
    return share_spent(fit) >= 1 || fit->lost >= LOSSES_MOST || (fit->settings->may_stop && ffp_cancelled());
}

static void average(Fit *fit, double share) {
    if (!fit->mean.count || share < 1 - fit->settings->mean) return;
    fit->averaged++;
    const double late = fit->settings->mean_late;
    ffp_parameters_average(&fit->parameters, (real)((late + 1) / (late + (double)fit->averaged)), &fit->mean);
}

// The gradients of one or two views, and as many steps behind each other: the second one's is then that of a
// state one step back.
static void take_steps(Fit *fit, const int *views, int n, FfpFitLoss *losses) {
    FfpFitView looks[2];
    for (int i = 0; i < n; i++) {
        clear(&fit->grad[i]);
        looks[i] = (FfpFitView){views[i], fit->step + 1 + i, &fit->grad[i], &losses[i]};
    }
    ffp_photo_loss_backward(fit->viewer, &fit->gaussians, looks, n);
    const FfpGrowth *growth = fit->settings->growth;
    if (growth)
        growth->note(growth->state, &fit->gaussians, &fit->grad[0], &fit->capture->views[views[0]].camera);
    for (int i = 0; i < n; i++) ffp_parameters_pull_back(&fit->parameters, &fit->gaussians, &fit->grad[i]);
    for (int i = 0; i < n; i++) {
        const double share = share_spent(fit);
        ffp_gaussian_adam_step(&fit->adam_state, &fit->parameters, &fit->grad[i], fit->settings, share);
        average(fit, share);
        fit->step++;
    }
    fit->grown =
        growth && growth->step(growth->state, fit->step, &fit->parameters, &fit->gaussians, &fit->adam_state);
    if (fit->grown) {
        ffp_gaussians_free(&fit->gaussians);
        ffp_gaussians_free(&fit->grad[0]);
        fit->gaussians = ffp_gaussians_new(fit->parameters.numbers.count);
        fit->grad[0] = ffp_gaussians_new(fit->parameters.numbers.count);
    }
    ffp_parameters_decode(&fit->parameters, &fit->gaussians);
}

// False when the metrics cannot be written.
static bool tell(Fit *fit, const Round *round) {
    char extra[96];
    const double seconds = ffp_seconds() - fit->started;
    snprintf(extra, sizeof extra, "step %lld, loss %.4f, %.2f dB, %lld Gaussians", (long long)fit->step,
             round->total, round->psnr, (long long)fit->gaussians.count);
    if (!fit->settings->quiet)
        ffp_task_step(&fit->progress, (int64_t)(share_spent(fit) * (double)fit->progress.total), extra);
    if (!fit->settings->metrics) return true;
    fprintf(fit->settings->metrics,
            "{\"step\": %lld, \"seconds\": %.3f, \"loss\": %.6f, \"psnr\": %.4f, \"gaussians\": %lld}\n",
            (long long)fit->step, seconds, round->total, round->psnr, (long long)fit->gaussians.count);
    return fflush(fit->settings->metrics) == 0;
}

// Pairs keep one order in all rounds, so that a view's looks are the same number of steps apart: a random one
// looks at some views twice in short order and leaves others for long.
static void put_in_order(Fit *fit) {
    if (fit->settings->pairs && fit->step > 0) return;
    shuffle(fit);
    if (fit->settings->pairs) ffp_pair_opposites(fit->capture, fit->order);
}

// All views once, or until the end; returns how many. On a device no step waits for its loss.
static int step_through(Fit *fit) {
    const int n = fit->capture->n_views;
    int done = 0;
    memset(fit->losses, 0, (size_t)n * sizeof *fit->losses);
    put_in_order(fit);
    ffp_losses_defer();
    while (done < n && !over(fit)) {
        const int at_once = fit->grad[1].count && done + 1 < n && steps_left(fit) > 1 ? 2 : 1;
        take_steps(fit, fit->order + done, at_once, &fit->losses[done]);
        done += at_once;
    }
    ffp_losses_collect();
    return done;
}

// The loss of a round is that of the states it went through.
static bool one_round(Fit *fit, FfpError *err) {
    const int n = fit->capture->n_views;
    const int done = step_through(fit);
    Round sum = {0};
    for (int i = 0; i < done; i++) {
        sum.total += fit->losses[i].pictures + fit->losses[i].maps;
        sum.psnr += fit->losses[i].psnr;
    }
    if (!isfinite(sum.total))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, fit->capture->folder, "the loss is no longer finite");
    if (done < n) return true;
    sum.total /= n;
    sum.psnr /= n;
    if (!tell(fit, &sum)) return ffp_fail(err, FFP_ERROR_IO, NULL, "cannot write the metrics");
    fit->rounds++;
    if (fit->rounds == 1) fit->first_psnr = sum.psnr;
    fit->lost = sum.psnr < fit->first_psnr ? fit->lost + 1 : 0;
    if (sum.psnr > fit->best_psnr && !fit->grown) {
        fit->best_psnr = sum.psnr;
        fit->best_round = fit->rounds;
        copy(&fit->best, &fit->gaussians);
    }
    return true;
}

static Fit fit_new(const FfpGaussians *gaussians, const FfpCapture *capture, const int *patterns,
                   int n_patterns, const FfpRefineSettings *settings) {
    Fit fit = {.capture = capture, .settings = settings, .first_psnr = -INFINITY, .best_psnr = -INFINITY};
    fit.started = ffp_seconds();
    fit.viewer = ffp_photo_loss_new(capture, patterns, n_patterns, settings);
    fit.parameters = ffp_parameters_new(gaussians, !settings->growth, settings->growth);
    fit.gaussians = ffp_gaussians_new(gaussians->count);
    fit.grad[0] = ffp_gaussians_new(gaussians->count);
    fit.grad[1] = ffp_gaussians_new(settings->pairs ? gaussians->count : 0);
    fit.adam_state = ffp_gaussian_adam_new(&fit.parameters, settings);
    fit.mean = ffp_gaussians_new(settings->mean > 0 ? gaussians->count : 0);
    fit.losses = ffp_alloc((size_t)capture->n_views, sizeof *fit.losses);
    fit.order = ffp_alloc((size_t)capture->n_views, sizeof *fit.order);
    for (int v = 0; v < capture->n_views; v++) fit.order[v] = v;
    fit.rng = ffp_rng(settings->seed, 1);
    ffp_parameters_decode(&fit.parameters, &fit.gaussians);
    ffp_gaussians_take_notes(&fit.gaussians, gaussians);
    copy(&fit.best, &fit.gaussians);
    return fit;
}

static void fit_free(Fit *fit) {
    ffp_photo_loss_free(fit->viewer);
    ffp_parameters_free(&fit->parameters);
    ffp_gaussians_free(&fit->gaussians);
    for (int i = 0; i < 2; i++) ffp_gaussians_free(&fit->grad[i]);
    ffp_gaussians_free(&fit->best);
    ffp_gaussians_free(&fit->mean);
    ffp_gaussian_adam_free(&fit->adam_state);
    ffp_free(fit->order);
    ffp_free(fit->losses);
}

static double psnr_of(const Fit *fit, const FfpGaussians *gaussians) {
    return ffp_photo_loss_psnr(fit->viewer, gaussians);
}

// The mean of the last steps' numbers is nearer to what they wander about than any of them is (Polyak and
// Juditsky 1992), with more weight on later ones, as the fit is still under way (Shamir and Zhang 2013),
// unless it has gone astray by then.
static bool mean_is_due(const Fit *fit) {
    return fit->averaged > 0 && fit->rounds > 0 && fit->best_round + 1 >= fit->rounds;
}

// Chooses the fit's result: the mean, the best round's state, or `before`, of which nothing is copied.
// Rounds' own figures, which are of states on the way, tell when the mean has clearly gained; otherwise all
// are judged.
static bool choose(Fit *fit, const FfpGaussians *before) {
    const bool clear = fit->settings->growth || fit->best_psnr > fit->first_psnr + FFP_CLEAR_GAIN;
    FfpGaussians mean = {0};
    if (mean_is_due(fit)) {
        FfpParameters numbers = fit->parameters;
        numbers.numbers = fit->mean;
        copy(&mean, &fit->best);
        ffp_parameters_decode(&numbers, &mean);
    }
    const double of_best = clear ? 0 : psnr_of(fit, &fit->best),
                 of_mean = mean.count && !clear ? psnr_of(fit, &mean) : 0;
    const double most = of_mean > of_best ? of_mean : of_best;
    if (mean.count && of_mean >= of_best) copy(&fit->best, &mean);
    ffp_gaussians_free(&mean);
    return clear || most >= psnr_of(fit, before);
}

// Under a limit of steps progress counts these, otherwise seconds.
static FfpTask progress_of(const FfpRefineSettings *s) {
    return ffp_task(s->label ? s->label : "refining", s->seconds > 0 ? (int64_t)ceil(s->seconds) : s->steps);
}

const char *ffp_refine_beyond_devices(const FfpRefineSettings *settings) {
    if (settings->growth) return "density control";
    return settings->smooth > 0 ? "smoothing over neighbours" : NULL;
}

bool ffp_refine(FfpGaussians *gaussians, const FfpCapture *capture, const int *patterns, int n_patterns,
                const FfpRefineSettings *settings, FfpRefineResult *result, FfpError *err) {
    if (gaussians->count < 1)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, capture->folder, "no Gaussians to refine");
    if (!(settings->steps > 0) && !(settings->seconds > 0))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, NULL, "a fit needs a limit of steps or seconds");
    const char *beyond = ffp_device() ? ffp_refine_beyond_devices(settings) : NULL;
    if (beyond)
        return ffp_fail(err, FFP_ERROR_UNSUPPORTED, capture->folder, "%s runs on the CPU only", beyond);
    Fit fit = fit_new(gaussians, capture, patterns, n_patterns, settings);
    *result = (FfpRefineResult){0};
    if (settings->measure) result->psnr_before = ffp_photo_loss_psnr(fit.viewer, gaussians);
    if (!settings->quiet) fit.progress = progress_of(settings);
    bool ok = true;
    while (ok && !over(&fit)) ok = one_round(&fit, err);
    if (!settings->quiet) ffp_task_end(&fit.progress);
    if (ok) {
        result->dropped = !choose(&fit, gaussians);
        if (!result->dropped) copy(gaussians, &fit.best);
        if (settings->measure) result->psnr_after = ffp_photo_loss_psnr(fit.viewer, gaussians);
        result->steps = fit.step;
        result->first_psnr = fit.first_psnr;
        result->best_psnr = fit.best_psnr;
        result->gaussians = gaussians->count;
        result->seconds = ffp_seconds() - fit.started;
        result->stopped = settings->may_stop && ffp_cancelled();
    }
    fit_free(&fit);
    return ok;
}
