// Fitting a capture's Gaussians to its pictures, in the capture's own units.
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include "base/arena.h"
#include "base/file.h"
#include "denoise/denoise.h"
#include "eval/reconstruct.h"
#include "eval/relight.h"
#include "refine/refine.h"

#define SCRATCH_POINTS 20000
#define SCRATCH_STEPS 20000 // as GS-ProCams
#define REFINE_SECONDS 30

static atomic_bool interrupted;
static void on_signal(int number) {
    (void)number;
    interrupted = true;
}

static bool check_pictures(const FfpCapture *capture, int pattern, FfpError *err) {
    for (int v = 0; v < capture->n_views; v++)
        if (!capture->views[v].images[pattern].data)
            return ffp_fail(err, capture->folder, "view %s has no picture under pattern %s",
                            capture->views[v].id, capture->patterns[pattern].name);
    return true;
}

// Black, white and the patterns to fit to, without doubles; indices into the capture's.
static int choose_patterns(const FfpCapture *capture, const FfpRefinement *options,
                           int chosen[FFP_PATTERNS_MAX], FfpError *err) {
    int count = 0;
    chosen[count++] = capture->black, chosen[count++] = capture->white;
    const int wanted = options->n_patterns ? options->n_patterns : 1;
    for (int i = 0; i < wanted; i++) {
        const char *name = options->n_patterns ? options->patterns[i] : NULL;
        const int found = ffp_capture_active_pattern(capture, name, err);
        bool known = false;
        if (found < 0) return -1;
        for (int j = 0; j < count; j++) known = known || chosen[j] == found;
        if (!known) chosen[count++] = found;
    }
    for (int i = 0; i < count; i++)
        if (!check_pictures(capture, chosen[i], err)) return -1;
    return count;
}

static FfpRefineSettings settings_of(const FfpRefinement *options, bool scratch) {
    FfpRefineSettings s = scratch ? ffp_scratch_defaults() : ffp_refine_defaults();
    const bool limited = options->steps > 0 || options->seconds > 0;
    s.render = ffp_drawing_settings(options->drawing, NULL);
    s.steps = limited || !scratch ? options->steps : SCRATCH_STEPS;
    s.seconds = limited || scratch ? options->seconds : REFINE_SECONDS;
    s.seed = options->seed;
    s.stop = &interrupted;
    return s;
}

static void tell_story(FfpRefinementStory *story, const FfpRefineResult *result) {
    if (!story) return;
    *story = (FfpRefinementStory){result->psnr_before, result->psnr_after, result->steps,  result->gaussians,
                                  result->seconds,     result->stopped,    result->dropped};
}

// Fits in the unit sphere, with signals caught. Gaussians without elements: from scratch.
static bool fit(FfpGaussians *gaussians, const FfpCapture *capture, const int *patterns, int n_patterns,
                FfpRefineSettings *settings, double noise, FfpRefinementStory *story, FfpError *err) {
    FfpCapture normalised = ffp_normalised_alias(capture);
    FfpImage *clean = ffp_take_noise_away(&normalised, patterns, n_patterns, &noise);
    FfpRefineResult result = {0};
    struct sigaction action = {.sa_handler = on_signal}, old_int, old_term;
    bool ok = gaussians->count > 0 ||
              ffp_scratch_gaussians(gaussians, &normalised, SCRATCH_POINTS, settings->seed, err);
    interrupted = false;
    sigaction(SIGINT, &action, &old_int);
    sigaction(SIGTERM, &action, &old_term);
    ok = ok && ffp_refine(gaussians, &normalised, patterns, n_patterns, settings, &result, err);
    sigaction(SIGINT, &old_int, NULL);
    sigaction(SIGTERM, &old_term, NULL);
    if (ok) {
        ffp_gaussians_transform(gaussians, capture->centre, capture->radius);
        tell_story(story, &result);
    }
    ffp_denoise_free(clean, capture, patterns, n_patterns);
    ffp_normalised_alias_free(&normalised);
    return ok;
}

// Opens the metrics, which grow line by line, and fits.
static bool fit_with_metrics(FfpGaussians *gaussians, const FfpCapture *capture, const FfpRefinement *options,
                             bool scratch, FfpRefinementStory *story, FfpError *err) {
    int patterns[FFP_PATTERNS_MAX];
    FfpRefineSettings settings = settings_of(options, scratch);
    const int n_patterns = choose_patterns(capture, options, patterns, err);
    if (n_patterns < 0) return false;
    if (options->metrics && !(settings.metrics = fopen(options->metrics, "w")))
        return ffp_fail(err, options->metrics, "cannot write");
    const bool ok = fit(gaussians, capture, patterns, n_patterns, &settings, options->noise, story, err);
    if (settings.metrics && fclose(settings.metrics) != 0 && ok)
        return ffp_fail(err, options->metrics, "cannot write");
    return ok;
}

bool ffp_refine_gaussians(FfpGaussians *gaussians, const FfpCapture *capture, const FfpRefinement *options,
                          FfpRefinementStory *story, FfpError *err) {
    if (gaussians->count < 1) return ffp_fail(err, NULL, "there are no Gaussians to refine");
    const real centre[3] = {-capture->centre[0] / capture->radius, -capture->centre[1] / capture->radius,
                            -capture->centre[2] / capture->radius};
    ffp_gaussians_transform(gaussians, centre, 1 / capture->radius);
    if (fit_with_metrics(gaussians, capture, options, false, story, err)) return true;
    ffp_gaussians_transform(gaussians, capture->centre, capture->radius);
    return false;
}

FfpGaussians *ffp_fit_from_scratch(const FfpCapture *capture, const FfpRefinement *options,
                                   FfpRefinementStory *story, FfpError *err) {
    FfpGaussians *gaussians = ffp_alloc(1, sizeof *gaussians);
    if (fit_with_metrics(gaussians, capture, options, true, story, err)) return gaussians;
    ffp_gaussians_close(gaussians);
    return NULL;
}
