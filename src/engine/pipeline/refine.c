#include "engine/pipeline/refine.h"
#include "core/base/call.h"
#include "engine/pipeline/fit.h"
#include "engine/pipeline/relight.h"
#include "engine/refine/refine.h"

typedef struct Work {
    FfpGaussians fitted;
    const char *made_from; // before
    const FfpRefinement *options;
    FfpRefinementStats *stats;
} Work;

static FfpRefineSettings settings_of(const FfpRefinement *options, FILE *metrics) {
    FfpRefineSettings s = ffp_refine_defaults();
    const bool limited = options->steps > 0 || options->limit_s > 0;
    s.render = ffp_drawing_settings(options->drawing, NULL);
    s.steps = options->steps;
    s.seconds = limited ? options->limit_s : FFP_REFINE_SECONDS;
    s.seed = options->seed;
    s.may_stop = true;
    s.metrics = metrics;
    return s;
}

static bool fit(void *argument, const FfpFitPhotographs *p, FfpError *err) {
    Work *work = argument;
    const FfpRefineSettings settings = settings_of(work->options, p->metrics);
    FfpRefineResult result = {0};
    ffp_cancel_hold_off(true); // from here on what there is counts
    if (!ffp_refine_offered(&work->fitted, p->capture, p->patterns, p->n_patterns, &settings, &result, err))
        return false;
    ffp_fit_done(&work->fitted, work->made_from, p, &result, work->stats);
    return true;
}

bool ffp_refinement_run(FfpGaussians *gaussians, const FfpCapture *capture, const FfpRefinement *options,
                        FfpRefinementStats *stats, FfpError *err) {
    if (gaussians->count < 1) return ffp_fail(err, FFP_ERROR_ARGUMENT, NULL, "no Gaussians to refine");
    const real centre[3] = {-capture->centre[0] / capture->radius, -capture->centre[1] / capture->radius,
                            -capture->centre[2] / capture->radius};
    Work work = {ffp_gaussians_copy(gaussians), gaussians->made_from, options, stats};
    ffp_gaussians_transform(&work.fitted, centre, 1 / capture->radius);
    const bool ok = ffp_fit_call(&(FfpFitCall){capture, options, false, fit, &work}, err);
    if (ok) {
        const FfpGaussians before = *gaussians;
        *gaussians = work.fitted;
        work.fitted = before;
    }
    ffp_gaussians_free(&work.fitted);
    return ok;
}
