// The methods to compare with (ffprocams/lab.h), fitted to a capture's pictures in the capture's own
// units.
#include "core/base/call.h"
#include "core/base/file.h"
#include "engine/pipeline/fit.h"
#include "engine/pipeline/relight.h"
#include "ffprocams/lab.h"
#include "lab/baselines/field.h"
#include "lab/baselines/scratch.h"
#include "product/api/arguments.h"

#define SCRATCH_STEPS 20000 // as GS-ProCams
#define FIELD_SECONDS 300

typedef struct Call {
    const FfpCapture *capture;
    const FfpRefinement *options;
    const FfpGaussians *points; // where Gaussians begin, or NULL
    const char *checkpoint;     // of a field
    FfpGaussians *gaussians;    // the result, or
    FfpNeuralField *field;
    FfpRefinementStats *stats;
} Call;

static FfpScratchSettings scratch_settings(const FfpRefinement *options, FILE *metrics) {
    FfpScratchSettings s = ffp_scratch_defaults(options->drawing.form == FFP_FORM_GS_PROCAMS);
    const bool limited = options->steps > 0 || options->limit_s > 0;
    s.fit.render = ffp_drawing_settings(options->drawing, NULL);
    s.fit.steps = limited ? options->steps : SCRATCH_STEPS;
    s.fit.seconds = options->limit_s;
    s.fit.seed = options->seed;
    s.fit.may_stop = true;
    s.fit.metrics = metrics;
    return s;
}

// From world units to those of the normalised capture, as ffp_fit_done goes the other way.
static void into_the_sphere(real *centres, int64_t count, const FfpCapture *capture) {
    for (int64_t i = 0; i < count; i++)
        for (int k = 0; k < 3; k++)
            centres[3 * i + k] = (centres[3 * i + k] - capture->centre[k]) / capture->radius;
}

static bool fit_scratch(void *argument, const FfpFitPhotographs *p, FfpError *err) {
    const Call *call = argument;
    FfpScratchSettings settings = scratch_settings(call->options, p->metrics);
    FfpGaussians points = {0};
    if (call->points) {
        points = ffp_gaussians_copy(call->points);
        into_the_sphere(points.centre, points.count, p->source);
        settings.given = &points;
    }
    FfpRefineResult result = {0};
    const bool ok =
        ffp_scratch_fit(call->gaussians, p->capture, p->patterns, p->n_patterns, &settings, &result, err);
    ffp_gaussians_free(&points);
    if (!ok) return false;
    ffp_fit_done(call->gaussians, "", p, &result, call->stats);
    return true;
}

static bool scratch_call(void *argument, FfpError *err) {
    Call *call = argument;
    call->gaussians = ffp_alloc(1, sizeof *call->gaussians);
    if (ffp_fit_call(&(FfpFitCall){call->capture, call->options, false, fit_scratch, call}, err)) return true;
    ffp_gaussians_close(call->gaussians);
    return false;
}

FfpGaussians *ffp_fit_from_scratch(FfpContext *context, const FfpCapture *capture, const FfpGaussians *points,
                                   const FfpRefinement *options, FfpRefinementStats *stats, FfpError *err) {
    FfpRefinement own = ffp_refinement_defaults();
    Call call = {.capture = capture, .options = &own, .points = points, .stats = stats};
    if (!ffp_need_photographs(capture, err) || !ffp_take_options(&own, options, "FfpRefinement", err) ||
        !ffp_check_refinement(&own, err) || (points && !ffp_need_gaussians(points, err)))
        return NULL;
    return ffp_call_run(context, scratch_call, &call, err) ? call.gaussians : NULL;
}

static FfpFieldSettings field_settings(const Call *call, FILE *metrics) {
    const FfpRefinement *options = call->options;
    FfpFieldSettings s = ffp_field_defaults();
    const bool limited = options->steps > 0 || options->limit_s > 0;
    s.steps = options->steps;
    s.seconds = limited ? options->limit_s : FIELD_SECONDS;
    s.seed = options->seed;
    s.may_stop = true;
    s.metrics = metrics;
    s.checkpoint = call->checkpoint;
    s.noise = options->noise;
    s.source = call->capture;
    return s;
}

static bool fit_field(void *argument, const FfpFitPhotographs *p, FfpError *err) {
    const Call *call = argument;
    const FfpFieldSettings settings = field_settings(call, p->metrics);
    FfpFieldResult result = {0};
    if (!ffp_field_fit(call->field, p->capture, p->patterns, p->n_patterns, &settings, &result, err))
        return false;
    if (call->stats)
        *call->stats = (FfpRefinementStats){.psnr_after = result.psnr,
                                            .steps = result.steps,
                                            .elapsed_s = result.seconds,
                                            .stopped = result.stopped};
    return true;
}

static bool field_call(void *argument, FfpError *err) {
    Call *call = argument;
    const bool goes_on = call->checkpoint && ffp_is_file(call->checkpoint);
    call->field = ffp_alloc(1, sizeof *call->field);
    if (ffp_fit_call(&(FfpFitCall){call->capture, call->options, goes_on, fit_field, call}, err)) return true;
    ffp_neural_field_close(call->field);
    return false;
}

FfpNeuralField *ffp_fit_neural_field(FfpContext *context, const FfpCapture *capture,
                                     const FfpRefinement *options, const char *checkpoint,
                                     FfpRefinementStats *stats, FfpError *err) {
    FfpRefinement own = ffp_refinement_defaults();
    Call call = {.capture = capture, .options = &own, .checkpoint = checkpoint, .stats = stats};
    if (!ffp_need_photographs(capture, err) || !ffp_take_options(&own, options, "FfpRefinement", err) ||
        !ffp_check_refinement(&own, err))
        return NULL;
    return ffp_call_run(context, field_call, &call, err) ? call.field : NULL;
}

typedef struct File {
    const char *path;
    FfpNeuralField *field;
} File;

static bool open_field(void *argument, FfpError *err) {
    File *call = argument;
    call->field = ffp_alloc(1, sizeof *call->field);
    if (ffp_neural_field_read(call->field, call->path, err)) return true;
    ffp_free(call->field);
    return false;
}

FfpNeuralField *ffp_neural_field_open(FfpContext *context, const char *path, FfpError *err) {
    File call = {.path = path};
    if (!ffp_need(path, "path", err)) return NULL;
    return ffp_call_run(context, open_field, &call, err) ? call.field : NULL;
}

static bool save_field(void *argument, FfpError *err) {
    const File *call = argument;
    return ffp_neural_field_write(call->field, call->path, err);
}

bool ffp_neural_field_save(FfpContext *context, const FfpNeuralField *field, const char *path,
                           FfpError *err) {
    File call = {path, (FfpNeuralField *)field};
    if (!ffp_need(field, "field", err) || !ffp_need(path, "path", err)) return false;
    return ffp_call_run(context, save_field, &call, err);
}

void ffp_neural_field_close(FfpNeuralField *field) {
    if (!field) return;
    ffp_neural_field_free(field);
    ffp_free(field);
}
