// From a capture to Gaussians in its own units: normalise, match, (network,) back to the world.
#include <stdio.h>
#include <stdlib.h>
#include "base/arena.h"
#include "base/log.h"
#include "capture/capture.h"
#include "denoise/denoise.h"
#include "eval/reconstruct.h"
#include "eval/relight.h"
#include "gaussians/gaussians.h"
#include "match/match.h"
#include "match/refute.h"
#include "network/network.h"
#include "refine/refine.h"

#define NETWORK_LOSS_MAX 1 // dB against the classical start

FfpCapture ffp_normalised_alias(const FfpCapture *capture) {
    FfpCapture alias = *capture;
    alias.views = ffp_alloc(capture->n_views, sizeof *alias.views);
    for (int v = 0; v < capture->n_views; v++) {
        alias.views[v] = capture->views[v];
        if (alias.views[v].depth.data) alias.views[v].depth = ffp_image_copy(&capture->views[v].depth);
    }
    ffp_capture_normalise(&alias, capture->centre, capture->radius);
    return alias;
}

void ffp_normalised_alias_free(FfpCapture *alias) {
    for (int v = 0; v < alias->n_views; v++) ffp_image_free(&alias->views[v].depth);
    free(alias->views);
    alias->views = NULL;
}

FfpImage *ffp_take_noise_away(FfpCapture *alias, const int *photographs, int n, double *noise) {
    if (n < FFP_PHOTOGRAPHS) return NULL;
    if (*noise < 0) *noise = ffp_noise_estimate(alias, photographs);
    return *noise > 0 ? ffp_denoise(alias, photographs, n, *noise) : NULL;
}

// Matching lays all views' pixels in one array, and the network cuts them into patches.
bool ffp_check_fit(const FfpCapture *capture, const FfpModel *model, FfpError *err) {
    const FfpCamera *first = &capture->views[0].camera;
    for (int v = 1; v < capture->n_views; v++) {
        const FfpCamera *camera = &capture->views[v].camera;
        if (camera->width != first->width || camera->height != first->height)
            return ffp_fail(err, capture->folder,
                            "views %s and %s differ in size: a reconstruction needs one size",
                            capture->views[0].id, capture->views[v].id);
    }
    if (!model) return true;
    const int patch = model->config.patch;
    if (first->width % patch || first->height % patch)
        return ffp_fail(err, capture->folder,
                        "the model does not fit: image sides of %d x %d are not multiples of its patch of %d",
                        first->width, first->height, patch);
    return true;
}

static bool run_network(FfpGaussians *out, const FfpModel *model, const FfpCapture *capture,
                        const FfpStart *start, int active, FfpError *err) {
    FfpRun *run = ffp_run_new();
    const bool ok = ffp_model_forward(model, run, capture, start, active, err);
    if (ok) *out = ffp_gaussians_copy(&run->gaussians); // the run's own live only as long as the run
    ffp_run_free(run);
    return ok;
}

// What a reconstruction passes on from step to step.
typedef struct Work {
    FfpCapture capture; // normalised, its photographs without noise
    int photographs[FFP_PHOTOGRAPHS];
    FfpStart start;
    FfpGaussians result;
} Work;

// PSNR on the photographs that the reconstruction is made from; one sample a pixel is enough to compare.
static double score(const Work *w, const FfpGaussians *gaussians, const FfpReconstruction *options) {
    FfpRenderSettings settings = ffp_drawing_settings(options->drawing, options->model);
    settings.samples = 1;
    return ffp_photographs_psnr(gaussians, &w->capture, w->photographs, FFP_PHOTOGRAPHS, &settings);
}

// Keeps the classical start where the network shows the photographs clearly worse than it. A small loss may
// buy better new poses, which nobody can score.
static void judge_network(Work *w, const FfpReconstruction *options, FfpReconstructionStory *story) {
    FfpGaussians start = ffp_start_gaussians(&w->capture, &w->start);
    const double before = score(w, &start, options), after = score(w, &w->result, options);
    story->network_dropped = start.count > 0 && after < before - NETWORK_LOSS_MAX;
    if (story->network_dropped) {
        ffp_note("the network shows the photographs worse than the classical start, %.1f against %.1f dB: "
                 "the start is kept",
                 after, before);
        ffp_gaussians_free(&w->result);
        w->result = start;
    } else {
        ffp_gaussians_free(&start);
    }
}

// Between the prediction and the way back to the world.
static bool polish(Work *w, const FfpReconstruction *options, FfpReconstructionStory *story, FfpError *err) {
    FfpRefineSettings settings = ffp_polish_defaults(options->polish);
    FfpRefineResult result;
    settings.render = ffp_drawing_settings(options->drawing, options->model);
    if (!ffp_refine(&w->result, &w->capture, w->photographs, FFP_PHOTOGRAPHS, &settings, &result, err))
        return false;
    story->polish_dropped = result.dropped;
    if (result.dropped) ffp_note("the polish shows the photographs worse than before: it is left out");
    return true;
}

static bool predict(Work *w, const FfpReconstruction *options, FfpReconstructionStory *story, FfpError *err) {
    const int active = w->photographs[2];
    const FfpMatchSettings settings = ffp_match_defaults();
    double begin = ffp_seconds();
    if (!ffp_start_new(&w->start, &w->capture, active, &settings, err)) return false;
    story->start_s = ffp_seconds() - begin;
    if (!options->model) {
        w->result = ffp_start_gaussians(&w->capture, &w->start);
        return true;
    }
    begin = ffp_seconds();
    if (!run_network(&w->result, options->model, &w->capture, &w->start, active, err)) return false;
    judge_network(w, options, story);
    story->network_s = ffp_seconds() - begin;
    return true;
}

static bool predict_and_polish(Work *w, const FfpReconstruction *options, FfpReconstructionStory *story,
                               FfpError *err) {
    if (!predict(w, options, story, err)) return false;
    ffp_refute(w->result.opacity, w->result.centre, w->result.count, &w->capture, &w->start);
    const double begin = ffp_seconds();
    if (options->polish > 0 && w->result.count > 0 && !polish(w, options, story, err)) return false;
    story->polish_s = ffp_seconds() - begin;
    story->gaussians = w->result.count;
    return true;
}

FfpGaussians *ffp_reconstruct(const FfpCapture *capture, const FfpReconstruction *options,
                              FfpReconstructionStory *told, FfpError *err) {
    const int active = ffp_capture_active_pattern(capture, options->pattern, err);
    if (active < 0 || !ffp_check_fit(capture, options->model, err)) return NULL;
    Work w = {.capture = ffp_normalised_alias(capture),
              .photographs = {capture->black, capture->white, active}};
    FfpReconstructionStory story = {.noise = options->noise};
    FfpGaussians *gaussians = NULL;
    const double begin = ffp_seconds();
    FfpImage *clean = ffp_take_noise_away(&w.capture, w.photographs, FFP_PHOTOGRAPHS, &story.noise);
    story.denoise_s = ffp_seconds() - begin;
    snprintf(story.pattern, sizeof story.pattern, "%s", capture->patterns[active].name);
    if (predict_and_polish(&w, options, &story, err)) {
        ffp_gaussians_transform(&w.result, capture->centre, capture->radius);
        gaussians = ffp_alloc(1, sizeof *gaussians);
        *gaussians = w.result;
        if (told) *told = story;
    } else {
        ffp_gaussians_free(&w.result);
    }
    ffp_start_free(&w.start);
    ffp_denoise_free(clean, capture, w.photographs, FFP_PHOTOGRAPHS);
    ffp_normalised_alias_free(&w.capture);
    return gaussians;
}
