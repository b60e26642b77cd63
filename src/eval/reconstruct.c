// From a capture to Gaussians in its own units: normalise, match, (network,) back to the world.
#include <stdio.h>
#include <stdlib.h>
#include "base/arena.h"
#include "base/log.h"
#include "capture/capture.h"
#include "eval/reconstruct.h"
#include "eval/relight.h"
#include "gaussians/gaussians.h"
#include "match/match.h"
#include "network/network.h"
#include "refine/refine.h"

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

// Between the prediction and the way back to the world.
static bool polish(FfpGaussians *gaussians, const FfpCapture *normalised, int active,
                   const FfpReconstruction *options, FfpError *err) {
    const int patterns[] = {normalised->black, normalised->white, active};
    FfpRefineSettings settings = ffp_polish_defaults(options->polish);
    FfpRefineResult result;
    settings.render = ffp_drawing_settings(FFP_DRAWING_OURS, options->model);
    return ffp_refine(gaussians, normalised, patterns, 3, &settings, &result, err);
}

FfpGaussians *ffp_reconstruct(const FfpCapture *capture, const FfpReconstruction *options,
                              FfpReconstructionStory *story, FfpError *err) {
    const int active = ffp_capture_active_pattern(capture, options->pattern, err);
    if (active < 0 || !ffp_check_fit(capture, options->model, err)) return NULL;
    const double begin = ffp_seconds();
    FfpCapture normalised = ffp_normalised_alias(capture);
    const FfpMatchSettings settings = ffp_match_defaults();
    FfpStart start;
    FfpGaussians *gaussians = NULL;
    if (ffp_start_new(&start, &normalised, active, &settings, err)) {
        const double started = ffp_seconds();
        FfpGaussians result = {0};
        bool ok = true;
        if (options->model)
            ok = run_network(&result, options->model, &normalised, &start, active, err);
        else
            result = ffp_start_gaussians(&normalised, &start);
        const double predicted = ffp_seconds();
        if (ok && options->polish > 0 && result.count > 0)
            ok = polish(&result, &normalised, active, options, err);
        const double polished = ffp_seconds();
        if (ok) {
            ffp_gaussians_transform(&result, capture->centre, capture->radius);
            gaussians = ffp_alloc(1, sizeof *gaussians);
            *gaussians = result;
        }
        if (ok && story) {
            *story = (FfpReconstructionStory){.gaussians = result.count, .start_s = started - begin};
            story->network_s = options->model ? predicted - started : 0;
            story->polish_s = polished - predicted;
            snprintf(story->pattern, sizeof story->pattern, "%s", capture->patterns[active].name);
        }
        ffp_start_free(&start);
    }
    ffp_normalised_alias_free(&normalised);
    return gaussians;
}
