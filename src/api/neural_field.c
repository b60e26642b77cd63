// A neural reflectance field fitted to a capture's pictures, in the capture's own units; its file.
#include <string.h>
#include "api/arguments.h"
#include "base/call.h"
#include "denoise/denoise.h"
#include "api/reconstruct.h"
#include "api/refine.h"
#include "field/field.h"

#define FIELD_SECONDS 300

typedef struct Call {
    FfpNeuralField *field; // the result
    const FfpCapture *capture;
    const FfpRefinement *options;
    FfpRefinementStats *stats;
} Call;

static FfpFieldSettings settings_of(const FfpRefinement *options, FILE *metrics) {
    FfpFieldSettings s = ffp_field_defaults();
    const bool limited = options->steps > 0 || options->seconds > 0;
    s.steps = options->steps;
    s.seconds = limited ? options->seconds : FIELD_SECONDS;
    s.seed = options->seed;
    s.may_stop = true;
    s.metrics = metrics;
    s.checkpoint = options->checkpoint;
    s.noise = options->noise;
    return s;
}

// The field's rays look at all patterns.
static bool check_pictures(const FfpCapture *capture, const int *patterns, int n, FfpError *err) {
    for (int i = 0; i < capture->n_views * n; i++) {
        const FfpView *view = &capture->views[i / n];
        if (!view->images[patterns[i % n]].data)
            return ffp_fail(err, FFP_ERROR_ARGUMENT, capture->folder,
                            "view %s has no picture under pattern %s", view->id,
                            capture->patterns[patterns[i % n]].name);
    }
    return true;
}

// Fits in the unit sphere.
static bool fit(void *argument, FILE *metrics, FfpError *err) {
    const Call *call = argument;
    FfpFieldSettings settings = settings_of(call->options, metrics);
    int patterns[FFP_PATTERNS_MAX];
    const int n_patterns = ffp_capture_photographs(call->capture, call->options->patterns,
                                                   call->options->n_patterns, patterns, err);
    if (n_patterns < 0 || !check_pictures(call->capture, patterns, n_patterns, err)) return false;
    FfpCapture normalised = ffp_normalised_alias(call->capture);
    double noise = call->options->noise;
    FfpImage *clean = ffp_denoise_capture(&normalised, patterns, n_patterns, &noise);
    FfpFieldResult result = {0};
    settings.source = call->capture;
    ffp_cancel_hold_off(true); // from here on what there is counts
    const bool ok = ffp_field_fit(call->field, &normalised, patterns, n_patterns, &settings, &result, err);
    if (ok) {
        memcpy(call->field->centre, call->capture->centre, sizeof call->field->centre);
        call->field->radius = call->capture->radius;
    }
    if (ok && call->stats)
        *call->stats = (FfpRefinementStats){.psnr_after = result.psnr,
                                            .steps = result.steps,
                                            .seconds = result.seconds,
                                            .stopped = result.stopped};
    ffp_denoise_free(clean, call->capture, patterns, n_patterns);
    ffp_normalised_alias_free(&normalised);
    return ok;
}

static bool fit_call(void *argument, FfpError *err) {
    Call *call = argument;
    call->field = ffp_alloc(1, sizeof *call->field);
    if (ffp_refinement_with_metrics(call->options, fit, call, err)) return true;
    ffp_neural_field_close(call->field);
    return false;
}

FfpNeuralField *ffp_fit_neural_field(FfpContext *context, const FfpCapture *capture,
                                     const FfpRefinement *options, FfpRefinementStats *stats, FfpError *err) {
    Call call = {NULL, capture, options, stats};
    if (!ffp_need(capture, "capture", err) || !ffp_need(options, "options", err)) return NULL;
    return ffp_call_run(context, fit_call, &call, err) ? call.field : NULL;
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
