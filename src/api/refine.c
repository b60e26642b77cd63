// Fitting a capture's Gaussians to its pictures, in the capture's own units.
#include <string.h>
#include <stdio.h>
#include <stdlib.h>
#include "api/arguments.h"
#include "base/arena.h"
#include "base/call.h"
#include "base/file.h"
#include "denoise/denoise.h"
#include "api/reconstruct.h"
#include "api/refine.h"
#include "api/relight.h"
#include "refine/refine.h"

#define SCRATCH_POINTS 20000
#define CUBE_POINTS 100000  // as GS-ProCams
#define SCRATCH_STEPS 20000 // as GS-ProCams
#define REFINE_SECONDS 30

static FfpRefineSettings settings_of(const FfpRefinement *options, bool scratch) {
    FfpRefineSettings s = scratch ? ffp_scratch_defaults() : ffp_refine_defaults();
    const bool limited = options->steps > 0 || options->seconds > 0;
    s.render = ffp_drawing_settings(options->drawing, NULL);
    s.steps = limited || !scratch ? options->steps : SCRATCH_STEPS;
    s.seconds = limited || scratch ? options->seconds : REFINE_SECONDS;
    s.seed = options->seed;
    s.may_stop = true;
    s.one_picture = scratch && options->drawing.form == FFP_FORM_GS_PROCAMS;
    return s;
}

static void fill_stats(FfpRefinementStats *stats, const FfpRefineResult *result) {
    if (!stats) return;
    *stats = (FfpRefinementStats){result->psnr_before, result->psnr_after, result->steps,  result->gaussians,
                                  result->seconds,     result->stopped,    result->dropped};
}

// Fits in the unit sphere. Gaussians without elements: from scratch.
static bool fit(FfpGaussians *gaussians, const FfpCapture *capture, const int *patterns, int n_patterns,
                FfpRefineSettings *settings, double noise, FfpRefinementStats *stats, FfpError *err) {
    FfpCapture normalised = ffp_normalised_alias(capture);
    FfpImage *clean = ffp_denoise_capture(&normalised, patterns, n_patterns, &noise);
    FfpRefineResult result = {0};
    const bool cube = settings->one_picture; // all as GS-ProCams
    bool ok = gaussians->count > 0 ||
              (cube ? ffp_scratch_cube(gaussians, &normalised, CUBE_POINTS, settings->seed, err)
                    : ffp_scratch_gaussians(gaussians, &normalised, SCRATCH_POINTS, settings->seed, err));
    ffp_cancel_hold_off(true); // from here on what there is counts
    ok = ok && ffp_refine_offered(gaussians, &normalised, patterns, n_patterns, settings, &result, err);
    if (ok) {
        ffp_gaussians_transform(gaussians, capture->centre, capture->radius);
        fill_stats(stats, &result);
    }
    ffp_denoise_free(clean, capture, patterns, n_patterns);
    ffp_normalised_alias_free(&normalised);
    return ok;
}

bool ffp_refinement_with_metrics(const FfpRefinement *options,
                                 bool (*work)(void *argument, FILE *metrics, FfpError *err), void *argument,
                                 FfpError *err) {
    FILE *metrics = NULL;
    const bool goes_on = options->checkpoint && ffp_is_file(options->checkpoint);
    if (options->metrics && !(metrics = ffp_open_to_grow(options->metrics, goes_on, err))) return false;
    if (metrics) ffp_own_file(metrics);
    const bool ok = work(argument, metrics, err), lost = metrics && ferror(metrics);
    if (metrics && (ffp_close_file(metrics) != 0 || lost))
        return ffp_fail(err, FFP_ERROR_IO, options->metrics, "cannot write");
    return ok;
}

FfpRefinement ffp_refinement_defaults(void) {
    return (FfpRefinement){.seconds = 30, .noise = FFP_NOISE_ESTIMATED};
}

typedef struct Call {
    FfpGaussians *gaussians; // of a fit from scratch its result
    bool scratch;
    const FfpCapture *capture;
    const FfpRefinement *options;
    FfpRefinementStats *stats;
} Call;

// Gaussians are in the world's units afterwards, or what is in them is of no use to anybody.
static bool fit_with_metrics(void *argument, FILE *metrics, FfpError *err) {
    const Call *call = argument;
    int patterns[FFP_PATTERNS_MAX];
    FfpRefineSettings settings = settings_of(call->options, call->scratch);
    const int n_patterns = ffp_capture_photographs(call->capture, call->options->patterns,
                                                   call->options->n_patterns, patterns, err);
    char made_from[FFP_MADE_FROM] = "";
    settings.metrics = metrics;
    if (!call->scratch) memcpy(made_from, call->gaussians->made_from, sizeof made_from);
    if (n_patterns < 0 || !fit(call->gaussians, call->capture, patterns, n_patterns, &settings,
                               call->options->noise, call->stats, err))
        return false;
    for (int i = 2; i < n_patterns; i++) // behind black and white
        ffp_made_from_add(made_from, call->capture->patterns[patterns[i]].name);
    memcpy(call->gaussians->made_from, made_from, sizeof made_from);
    return true;
}

// On a copy: what fails leaves the caller's Gaussians as they were, to the bit.
static bool refine(void *argument, FfpError *err) {
    const Call *call = argument;
    FfpGaussians *gaussians = call->gaussians;
    const FfpCapture *capture = call->capture;
    if (gaussians->count < 1)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, NULL, "there are no Gaussians to refine");
    const real centre[3] = {-capture->centre[0] / capture->radius, -capture->centre[1] / capture->radius,
                            -capture->centre[2] / capture->radius};
    FfpGaussians fitted = ffp_gaussians_copy(gaussians);
    ffp_gaussians_transform(&fitted, centre, 1 / capture->radius);
    Call on_copy = {&fitted, false, capture, call->options, call->stats};
    const bool ok = ffp_refinement_with_metrics(call->options, fit_with_metrics, &on_copy, err);
    if (ok) {
        const FfpGaussians before = *gaussians;
        *gaussians = fitted, fitted = before;
    }
    ffp_gaussians_free(&fitted);
    return ok;
}

static bool check_arguments(const FfpCapture *capture, const FfpRefinement *options, FfpError *err) {
    return ffp_need(capture, "capture", err) && ffp_need(options, "options", err) &&
           ffp_check_drawing(options->drawing, err);
}

bool ffp_refine_gaussians(FfpContext *context, FfpGaussians *gaussians, const FfpCapture *capture,
                          const FfpRefinement *options, FfpRefinementStats *stats, FfpError *err) {
    Call call = {gaussians, false, capture, options, stats};
    if (!ffp_need(gaussians, "gaussians", err) || !check_arguments(capture, options, err)) return false;
    return ffp_call_run(context, refine, &call, err);
}

static bool fit_from_scratch(void *argument, FfpError *err) {
    Call *call = argument;
    call->gaussians = ffp_alloc(1, sizeof *call->gaussians);
    if (ffp_refinement_with_metrics(call->options, fit_with_metrics, call, err)) return true;
    ffp_gaussians_close(call->gaussians);
    return false;
}

FfpGaussians *ffp_fit_from_scratch(FfpContext *context, const FfpCapture *capture,
                                   const FfpRefinement *options, FfpRefinementStats *stats, FfpError *err) {
    Call call = {NULL, true, capture, options, stats};
    if (!check_arguments(capture, options, err)) return NULL;
    return ffp_call_run(context, fit_from_scratch, &call, err) ? call.gaussians : NULL;
}
