#include "engine/pipeline/fit.h"
#include "core/base/file.h"
#include "engine/denoise/denoise.h"
#include "engine/pipeline/normalised.h"

static bool fit_with_metrics(const FfpFitCall *fit, FfpFitPhotographs *photographs, FfpError *err) {
    const int n = photographs->n_patterns, *patterns = photographs->patterns;
    double noise = fit->options->noise;
    FfpCapture normalised = ffp_normalised_alias(fit->capture);
    FfpImage *clean = ffp_denoise_capture(&normalised, patterns, n, &noise);
    photographs->capture = &normalised;
    const bool ok = fit->work(fit->argument, photographs, err);
    ffp_denoise_free(clean, fit->capture, patterns, n);
    ffp_normalised_alias_free(&normalised);
    return ok;
}

bool ffp_fit_call(const FfpFitCall *fit, FfpError *err) {
    const char *path = fit->options->metrics;
    FILE *metrics = NULL;
    FfpFitPhotographs photographs = {.source = fit->capture};
    photographs.n_patterns = ffp_capture_photographs(fit->capture, fit->options->patterns,
                                                     fit->options->n_patterns, photographs.patterns, err);
    if (photographs.n_patterns < 0) return false; // before an old file of metrics is emptied
    if (path && !(metrics = ffp_open_to_grow(path, fit->goes_on, err))) return false;
    if (metrics) ffp_own_file(metrics);
    photographs.metrics = metrics;
    const bool ok = fit_with_metrics(fit, &photographs, err), lost = metrics && ferror(metrics);
    if (metrics && (ffp_close_file(metrics) != 0 || lost))
        return ffp_fail(err, FFP_ERROR_IO, path, "cannot write");
    return ok;
}

void ffp_fit_done(FfpGaussians *gaussians, const char *made_from, const FfpFitPhotographs *photographs,
                  const FfpRefineResult *result, FfpRefinementStats *stats) {
    const FfpCapture *capture = photographs->source;
    ffp_gaussians_keep_drawn(gaussians);
    ffp_gaussians_transform(gaussians, capture->centre, capture->radius);
    snprintf(gaussians->made_from, sizeof gaussians->made_from, "%s", made_from);
    for (int i = 2; i < photographs->n_patterns; i++) // behind black and white
        ffp_made_from_add(gaussians->made_from, capture->patterns[photographs->patterns[i]].name);
    if (stats)
        *stats = (FfpRefinementStats){.psnr_before = result->psnr_before,
                                      .psnr_after = result->psnr_after,
                                      .steps = result->steps,
                                      .gaussians = gaussians->count,
                                      .elapsed_s = result->seconds,
                                      .stopped = result->stopped,
                                      .dropped = result->dropped};
}
