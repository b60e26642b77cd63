// From a capture to Gaussians in its own units: normalise, match, (network,) back to the world.
#include "engine/pipeline/reconstruct.h"
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/call.h"
#include "core/base/device.h"
#include "core/base/log.h"
#include "core/base/memory.h"
#include "core/capture/capture.h"
#include "core/capture/pad.h"
#include "core/capture/uploaded.h"
#include "core/gaussians/gaussians.h"
#include "engine/denoise/denoise.h"
#include "engine/match/match.h"
#include "engine/match/prune.h"
#include "engine/network/network.h"
#include "engine/pipeline/margins.h"
#include "engine/pipeline/need.h"
#include "engine/pipeline/normalised.h"
#include "engine/pipeline/relight.h"
#include "engine/pipeline/scattered.h"
#include "engine/refine/pyramid.h"
#include "engine/refine/thin.h"

_Static_assert(FFP_POLISH_STEPS == FFP_POLISH_DEFAULT_STEPS, "one number, in two headers");

#define NETWORK_LOSS_MAX 1 // dB against the classical initialisation
#define POLISH_VIEWS 8     // up to which the polish has FFP_POLISH_STEPS
#define VIEWS_SCORED 16    // to see whether the network misleads
#define FEW_VIEWS 4        // fewer than these leave sides of any object out
#define SAME_PLACE 0.01    // between projectors' places that count as one, in radii
#define SPLATS_ALL 200000  // that are kept where nobody says how many,
#define LAYERS_OF_MORE 2   // and of more;
#define SCENE_LAYERS 1     // of a whole scene, whatever their number (docs/lab/notebook/layers.md)
#define SCENE_STEPS 2.5    // of the polish for each of an object's

// The state that a reconstruction passes from step to step.
typedef struct Work {
    FfpCapture capture; // normalised, its photographs without noise
    FfpCapture padded;  // the same with views of one size, of whole patches: for matching and the network
    int *photographs;   // [n_photographs] black, white, the patterns (ffp_capture_photographs)
    int n_photographs;
    FfpCapture there; // `capture` on a device, from its first use there; views NULL: it has had none
    FfpInitialisation start;
    FfpGaussians result;
    int64_t *pixel; // [result.count] index of each Gaussian's pixel
} Work;

#define FIRST_PATTERN 2 // of the photographs; the network sees it

static const int *patterns_of(const Work *w, int *n) {
    *n = w->n_photographs - FIRST_PATTERN;
    return w->photographs + FIRST_PATTERN;
}

// On the device that long work may use, or the CPU.
static bool run_network(Work *w, const FfpModel *model, const FfpPixelContext *context, bool fitted,
                        FfpError *err) {
    const FfpDevice *device = ffp_device_offered();
    ffp_device_use(device);
    FfpModel there = device ? ffp_model_uploaded(model) : *model;
    FfpRun *run = ffp_run_new(false);
    if (fitted) run->looks = 0;
    const bool ok =
        ffp_model_forward(&there, run, &w->padded, &w->start, context, w->photographs[FIRST_PATTERN], err);
    if (ok) { // the run's own live only as long as the run
        w->result = device ? ffp_gaussians_downloaded(&run->gaussians) : ffp_gaussians_copy(&run->gaussians);
        w->pixel = ffp_alloc((size_t)w->result.count + 1, sizeof *w->pixel);
        memcpy(w->pixel, run->pixel, (size_t)w->result.count * sizeof *w->pixel);
    }
    ffp_run_free(run);
    if (device) ffp_memory_free(there.values);
    ffp_device_use(NULL);
    return ok;
}

// Its tokens are matched with all patterns. fitted: a fit follows.
static bool predict_by_network(Work *w, const FfpModel *model, bool fitted, FfpError *err) {
    int n;
    const int *patterns = patterns_of(w, &n);
    FfpPixelContext context;
    if (!ffp_pixel_context_new(&context, &model->config, &w->padded, &w->start, patterns, n, err))
        return false;
    const bool ok = run_network(w, model, &context, fitted, err);
    ffp_pixel_context_free(&context);
    return ok;
}

// The photographs that a fit looks at: those under Gray codes come last. Returns their number.
static int fitted_photographs(const Work *w, int photographs[FFP_PATTERNS_MAX]) {
    int n = 0;
    for (; n < w->n_photographs; n++) photographs[n] = w->photographs[n];
    for (int p = ffp_patterns_shown(&w->capture); p < w->capture.n_patterns && n < FFP_PATTERNS_MAX; p++)
        photographs[n++] = p;
    return n;
}

// The capture on the device offered, where it stays for scores and fit; NULL: there is none, or pictures are
// reduced before they are looked at.
static const FfpCapture *capture_there(Work *w) {
    const FfpDevice *device = ffp_device_offered();
    int photographs[FFP_PATTERNS_MAX];
    if (!device || ffp_pyramid_side(&w->capture) > 1) return NULL;
    if (w->there.views) return &w->there;
    const int n = fitted_photographs(w, photographs);
    ffp_device_use(device);
    w->there = ffp_capture_uploaded(&w->capture, photographs, n);
    ffp_device_use(NULL);
    return &w->there;
}

// On the device, by one sample a pixel.
static double score_there(const FfpCapture *there, const Work *w, const FfpGaussians *gaussians,
                          FfpRenderSettings settings) {
    settings.samples = 1;
    ffp_device_use(ffp_device_offered());
    FfpGaussians splats = ffp_gaussians_uploaded(gaussians);
    const double psnr = ffp_photographs_psnr(&splats, there, w->photographs, w->n_photographs, &settings);
    ffp_gaussians_free(&splats);
    ffp_device_use(NULL);
    return psnr;
}

// PSNR of both on the photographs that the reconstruction is made from, of VIEWS_SCORED views if there are
// more.
static void score(Work *w, const FfpGaussians *const both[2], int64_t *const pixels[2],
                  const FfpReconstruction *options, double psnr[2]) {
    const FfpRenderSettings settings = ffp_drawing_settings(options->drawing, options->model);
    const FfpCapture *there = capture_there(w);
    FfpView views[VIEWS_SCORED];
    FfpOrigin origins[2];
    FfpCapture some = there ? *there : w->capture;
    for (int k = 0; k < VIEWS_SCORED && some.n_views > VIEWS_SCORED; k++)
        views[k] = some.views[k * some.n_views / VIEWS_SCORED];
    if (some.n_views > VIEWS_SCORED) {
        some.views = views;
        some.n_views = VIEWS_SCORED;
    }
    for (int i = 0; i < 2; i++) {
        origins[i] = (FfpOrigin){w->start.views, w->start.width, w->start.height, pixels[i]};
        if (there) psnr[i] = score_there(&some, w, both[i], settings);
    }
    if (!there) ffp_pyramid_psnr(both, origins, 2, &some, w->photographs, w->n_photographs, &settings, psnr);
}

// Keeps the classical initialisation where the network shows the photographs clearly worse than it. A small
// loss may buy better new poses, which nobody can score.
static void keep_initial_if_better(Work *w, const FfpReconstruction *options, FfpReconstructionStats *stats) {
    FfpGaussians start = ffp_initialisation_gaussians(&w->padded, &w->start);
    int64_t *pixel = ffp_initialisation_pixels(&w->start);
    double psnr[2];
    score(w, (const FfpGaussians *[]){&start, &w->result}, (int64_t *[]){pixel, w->pixel}, options, psnr);
    const double before = psnr[0], after = psnr[1];
    stats->network_dropped = start.count > 0 && after < before - NETWORK_LOSS_MAX;
    if (stats->network_dropped) {
        ffp_note("the network reproduces the photographs worse than the classical initialisation, %.1f "
                 "against %.1f dB: "
                 "the initialisation is used",
                 after, before);
        ffp_gaussians_free(&w->result);
        ffp_free(w->pixel);
        w->result = start;
        w->pixel = pixel;
    } else {
        ffp_gaussians_free(&start);
        ffp_free(pixel);
    }
}

// Every step looks at one view.
static int64_t polish_steps(const FfpReconstruction *options, const FfpCapture *capture) {
    if (options->polish >= 0) return options->polish;
    const int views = capture->n_views > POLISH_VIEWS ? capture->n_views : POLISH_VIEWS;
    return (int64_t)((capture->scene ? SCENE_STEPS : 1) * FFP_POLISH_STEPS * views / POLISH_VIEWS);
}

// Splats that a fit has moved onto the background of views would be seen beside the object from elsewhere.
static void keep_to_silhouettes(Work *w) {
    if (!w->capture.scene)
        ffp_prune_off_silhouettes(w->result.opacity, w->result.centre, w->result.count, &w->capture);
}

// Between the prediction and the way back to the world.
static bool polish(Work *w, const FfpReconstruction *options, FfpReconstructionStats *stats, FfpError *err) {
    FfpRefineSettings settings = ffp_polish_defaults(polish_steps(options, &w->capture));
    FfpRefineResult result;
    int patterns[FFP_PATTERNS_MAX];
    const int n = fitted_photographs(w, patterns);
    settings.there = capture_there(w);
    settings.codes = n - w->n_photographs;
    ffp_scattered_start(&w->result, &w->capture, patterns, n);
    const FfpOrigin origin = {w->start.views, w->start.width, w->start.height, w->pixel};
    settings.render = ffp_drawing_settings(options->drawing, options->model);
    if (!ffp_refine_pyramid(&w->result, &origin, &w->capture, patterns, n, &settings, &result, err))
        return false;
    stats->polish_dropped = result.dropped;
    if (result.dropped) ffp_note("the polish made the match with the photographs worse: it is discarded");
    keep_to_silhouettes(w);
    return true;
}

// It has learned objects, not whole scenes.
static bool uses_network(const FfpCapture *capture, const FfpReconstruction *options) {
    return options->model && !capture->scene;
}

static bool predict(Work *w, const FfpReconstruction *options, FfpReconstructionStats *stats, FfpError *err) {
    int n;
    const int *patterns = patterns_of(w, &n);
    FfpMatchSettings settings = ffp_match_defaults();
    settings.device = ffp_device_offered();
    double begin = ffp_seconds();
    FfpTask stage = ffp_task("matching", 0);
    const bool matched = ffp_initialisation_new(&w->start, &w->padded, patterns, n, &settings, err);
    ffp_task_end(&stage);
    if (!matched) return false;
    stats->initialisation_s = ffp_seconds() - begin;
    if (!uses_network(&w->capture, options)) {
        w->result = ffp_initialisation_gaussians(&w->padded, &w->start);
        w->pixel = ffp_initialisation_pixels(&w->start);
        return true;
    }
    begin = ffp_seconds();
    stage = ffp_task("network", 0);
    const bool predicted = predict_by_network(w, options->model, options->polish != 0, err);
    ffp_task_end(&stage);
    if (!predicted) return false;
    keep_initial_if_better(w, options, stats);
    stats->network_s = ffp_seconds() - begin;
    return true;
}

static bool repeated(const FfpCapture *capture, int view) {
    const FfpView *views = capture->views;
    for (int v = 0; v < view; v++)
        if (ffp_same_device(&views[v].camera, &views[view].camera) &&
            ffp_same_device(&views[v].projector, &views[view].projector))
            return true;
    return false;
}

// A view whose devices stand as in one before it shows nothing new, but would agree with that one whatever
// either says.
static void leave_repeated_views_out(FfpCapture *alias) {
    const int before = alias->n_views;
    int kept = 0;
    for (int v = 0; v < before; v++) {
        const FfpView view = alias->views[v];
        alias->views[kept] = view;
        if (repeated(alias, kept))
            ffp_image_free(&alias->views[kept].depth);
        else
            kept++;
    }
    alias->n_views = kept;
    if (kept < before)
        ffp_note("%d of %d views repeat the poses of others: they are left out", before - kept, before);
}

static void thin(Work *w, const FfpReconstruction *options) {
    double layers = options->layers;
    if (layers < 0 && w->capture.scene) layers = SCENE_LAYERS;
    if (layers < 0) layers = w->result.count > SPLATS_ALL ? LAYERS_OF_MORE : 0;
    ffp_thin(&w->result, w->pixel, &w->padded, w->start.confidence, layers);
}

// Of the start the polish needs no more than its size.
static void forget_maps(FfpInitialisation *start) {
    const FfpInitialisation size = {.views = start->views, .width = start->width, .height = start->height};
    ffp_initialisation_free(start);
    *start = size;
}

// Where one projector stood still, its shadows are what the photographs show them to be: baked, the fit finds
// them splat by splat, and no error of a depth somewhere else puts a surface into the dark.
static FfpBakedShadows shadows_to_bake(const FfpCapture *capture) {
    const FfpView *first = &capture->views[0];
    FfpBakedShadows baked = {.within = SAME_PLACE};
    for (int k = 0; k < 3; k++) baked.light[k] = first->projector.pose[4 * k + 3];
    const FfpGaussians here = {.baked = baked};
    for (int v = 1; v < capture->n_views; v++)
        if (!ffp_shadows_are_baked(&here, capture->views[v].projector.pose)) return (FfpBakedShadows){0};
    return baked;
}

static bool predict_and_polish(Work *w, const FfpReconstruction *options, FfpReconstructionStats *stats,
                               FfpError *err) {
    if (!predict(w, options, stats, err)) return false;
    w->result.baked = shadows_to_bake(&w->capture);
    const double begin = ffp_seconds();
    ffp_prune_contradicted(w->result.opacity, w->result.centre, w->pixel, w->result.count, &w->padded,
                           &w->start);
    thin(w, options);
    if (!w->capture.scene) forget_maps(&w->start);
    if (options->polish != 0 && w->result.count > 0 && !polish(w, options, stats, err)) return false;
    if (w->capture.scene) ffp_margins_add(&w->result, &w->padded, &w->start);
    stats->polish_s = ffp_seconds() - begin;
    return true;
}

// Nobody should be led to believe in surfaces that no view sees.
static void warn_of_gaps(const FfpCapture *capture) {
    if (capture->scene && capture->n_views < FEW_VIEWS)
        ffp_note(
            "%d view%s of a whole scene: what they do not see will be missing, and what the projector does "
            "not reach has little depth",
            capture->n_views, capture->n_views > 1 ? "s" : "");
    else if (capture->n_views == 1)
        ffp_note("one view shows one side of the object: the other side will be missing");
    else if (capture->n_views < FEW_VIEWS)
        ffp_note("%d views: sides of the object that none of them shows will be missing", capture->n_views);
}

// The photographs to work on, normalised, without noise, of one size. False: an option or the memory does not
// fit. *clean and photographs are end's.
static bool begin(Work *w, const FfpCapture *capture, const FfpReconstruction *options, int *photographs,
                  FfpImage **clean, FfpReconstructionStats *stats, FfpError *err) {
    const int n = ffp_capture_photographs(capture, options->patterns, options->n_patterns, photographs, err);
    if (n < 0 || !ffp_check_memory(capture, options, ffp_memory_available(), err)) return false;
    *w = (Work){.capture = ffp_normalised_alias(capture), .photographs = photographs, .n_photographs = n};
    leave_repeated_views_out(&w->capture);
    warn_of_gaps(&w->capture);
    *stats = (FfpReconstructionStats){.patterns = n - FIRST_PATTERN, .noise = options->noise};
    const double started = ffp_seconds();
    const FfpTask stage = ffp_task("noise", 0);
    *clean = ffp_denoise_capture(&w->capture, photographs, n, &stats->noise);
    ffp_task_end(&stage);
    stats->denoise_s = ffp_seconds() - started;
    snprintf(stats->pattern, sizeof stats->pattern, "%s", capture->patterns[photographs[FIRST_PATTERN]].name);
    w->padded = ffp_padded_capture(&w->capture, photographs, n,
                                   uses_network(&w->capture, options) ? options->model->config.patch : 1);
    return true;
}

static void end(Work *w, FfpImage *clean) {
    ffp_free(w->pixel);
    ffp_initialisation_free(&w->start);
    if (w->there.views) {
        ffp_device_use(ffp_device_offered());
        ffp_capture_free(&w->there);
        ffp_device_use(NULL);
    }
    ffp_padded_capture_free(&w->padded, &w->capture);
    ffp_denoise_free(clean, &w->capture, w->photographs, w->n_photographs);
    ffp_normalised_alias_free(&w->capture);
}

FfpGaussians *ffp_reconstruction_run(const FfpCapture *capture, const FfpReconstruction *options,
                                     FfpReconstructionStats *stats_out, FfpError *err) {
    int photographs[FFP_PATTERNS_MAX];
    Work w;
    FfpImage *clean;
    FfpReconstructionStats stats;
    FfpGaussians *gaussians = NULL;
    if (!begin(&w, capture, options, photographs, &clean, &stats, err)) return NULL;
    if (predict_and_polish(&w, options, &stats, err)) {
        ffp_gaussians_keep_drawn(&w.result);
        stats.gaussians = w.result.count;
        ffp_gaussians_transform(&w.result, capture->centre, capture->radius);
        gaussians = ffp_alloc(1, sizeof *gaussians);
        *gaussians = w.result;
        for (int i = FIRST_PATTERN; i < w.n_photographs; i++)
            ffp_made_from_add(gaussians->made_from, capture->patterns[photographs[i]].name);
        if (stats_out) *stats_out = stats;
    } else {
        ffp_gaussians_free(&w.result);
    }
    end(&w, clean);
    return gaussians;
}

static FfpPrepared *prepare(Work *w, const FfpModelConfig *config, FfpError *err) {
    int n;
    const int *patterns = patterns_of(w, &n);
    const FfpMatchSettings settings = ffp_match_defaults();
    FfpPixelContext context;
    if (!ffp_initialisation_new(&w->start, &w->padded, patterns, n, &settings, err) ||
        !ffp_pixel_context_new(&context, config, &w->padded, &w->start, patterns, n, err))
        return NULL;
    FfpPrepared *prepared = ffp_prepared_new(config, &w->padded, &w->start, &context, patterns[0], err);
    ffp_pixel_context_free(&context);
    return prepared;
}

FfpPrepared *ffp_reconstruction_inputs(const FfpCapture *capture, const FfpReconstruction *options,
                                       FfpError *err) {
    int photographs[FFP_PATTERNS_MAX];
    Work w;
    FfpImage *clean;
    FfpReconstructionStats stats;
    if (capture->scene) {
        ffp_fail(err, FFP_ERROR_UNSUPPORTED, capture->folder,
                 "a capture of a whole scene: the network has learned objects");
        return NULL;
    }
    if (!begin(&w, capture, options, photographs, &clean, &stats, err)) return NULL;
    FfpPrepared *prepared = prepare(&w, &options->model->config, err);
    end(&w, clean);
    return prepared;
}

// Mean of one figure (its offset) over the views that have it; NaN: none has.
static double mean_of(const FfpViewScore *scores, int n, size_t figure) {
    double sum = 0;
    int count = 0;
    for (int v = 0; v < n; v++) {
        const double value = *(const double *)((const char *)&scores[v] + figure);
        if (isfinite(value)) sum += value, count++;
    }
    return count > 0 ? sum / count : NAN;
}

bool ffp_reconstruction_score(const FfpGaussians *gaussians, const FfpCapture *capture,
                              const FfpReconstruction *options, FfpReconstructionStats *stats,
                              FfpError *err) {
    int photographs[FFP_PATTERNS_MAX + FFP_UNSEEN_MAX], least = 0;
    const double begin = ffp_seconds();
    const int n = ffp_capture_photographs(capture, options->patterns, options->n_patterns, photographs, err);
    if (n < 0) return false;
    stats->unseen = ffp_capture_unseen(capture, photographs, n, photographs + n);
    const FfpRenderSettings settings = ffp_drawing_settings(options->drawing, options->model);
    FfpViewScore *scores = ffp_alloc((size_t)capture->n_views, sizeof *scores);
    ffp_photographs_score(gaussians, capture, photographs, n + stats->unseen, stats->unseen, &settings,
                          scores);
    for (int v = 0; v < capture->n_views; v++)
        if (scores[v].psnr < scores[least].psnr) least = v;
    stats->psnr = mean_of(scores, capture->n_views, offsetof(FfpViewScore, psnr));
    stats->lit_psnr = mean_of(scores, capture->n_views, offsetof(FfpViewScore, lit));
    stats->unseen_psnr = mean_of(scores, capture->n_views, offsetof(FfpViewScore, unseen));
    stats->unseen_lit_psnr = mean_of(scores, capture->n_views, offsetof(FfpViewScore, unseen_lit));
    stats->least_psnr = scores[least].psnr;
    snprintf(stats->least_view, sizeof stats->least_view, "%s", capture->views[least].id);
    ffp_free(scores);
    stats->score_s = ffp_seconds() - begin;
    return true;
}
