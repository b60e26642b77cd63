// Patterns under which cameras see their targets.
#include "engine/pipeline/compensate.h"
#include "core/base/call.h"
#include "product/api/arguments.h"
#include "product/api/memory.h"

void ffp_compensation_defaults_into(FfpCompensation *options, size_t size) {
    ffp_give_defaults(options, size, &(FfpCompensation){.gain = 1, .steps = 30}, sizeof(FfpCompensation));
}

typedef struct Call {
    const FfpGaussians *gaussians;
    const FfpCapture *capture;
    const FfpCompensation *options;
    FfpCompensationStats *stats;
    FfpImages *images;
} Call;

// The targets that the caller holds in memory; NULL: they are files.
static FfpRaw *pictures_of(const FfpCompensation *options) {
    if (!options->pictures || options->n_targets < 1) return NULL;
    FfpRaw *pictures = ffp_alloc((size_t)options->n_targets, sizeof *pictures);
    for (int i = 0; i < options->n_targets; i++) pictures[i] = ffp_raw_of(&options->pictures[i]);
    return pictures;
}

static bool into_memory(void *argument, FfpError *err) {
    Call *call = argument;
    FfpRaw *pictures = pictures_of(call->options);
    call->images =
        ffp_compensation_run(call->gaussians, call->capture, call->options, pictures, call->stats, err);
    ffp_free(pictures);
    return call->images != NULL;
}

static bool check_targets(const FfpCompensation *options, FfpError *err) {
    if (options->pictures && options->targets)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "targets", "are given as files and as pictures");
    return options->pictures || ffp_need_texts(options->targets, options->n_targets, "targets", err);
}

static bool check_arguments(const FfpGaussians *gaussians, const FfpCapture *capture, FfpCompensation *own,
                            const FfpCompensation *options, FfpError *err) {
    return ffp_need_gaussians(gaussians, err) && ffp_need(capture, "capture", err) &&
           ffp_take_options(own, options, "FfpCompensation", err) &&
           ffp_need_texts(own->views, own->n_views, "views", err) && check_targets(own, err) &&
           ffp_check_drawing(own->drawing, err);
}

FfpImages *ffp_compensate_images(FfpContext *context, const FfpGaussians *gaussians,
                                 const FfpCapture *capture, const FfpCompensation *options,
                                 FfpCompensationStats *stats, FfpError *err) {
    FfpCompensation own = ffp_compensation_defaults();
    Call call = {gaussians, capture, &own, stats, NULL};
    if (!check_arguments(gaussians, capture, &own, options, err)) return NULL;
    return ffp_call_run(context, into_memory, &call, err) ? call.images : NULL;
}

static bool into_files(void *argument, FfpError *err) {
    const Call *call = argument;
    FfpRaw *pictures = pictures_of(call->options);
    const bool ok =
        ffp_compensation_write(call->gaussians, call->capture, call->options, pictures, call->stats, err);
    ffp_free(pictures);
    return ok;
}

bool ffp_compensate(FfpContext *context, const FfpGaussians *gaussians, const FfpCapture *capture,
                    const FfpCompensation *options, FfpCompensationStats *stats, FfpError *err) {
    FfpCompensation own = ffp_compensation_defaults();
    Call call = {gaussians, capture, &own, stats, NULL};
    if (!check_arguments(gaussians, capture, &own, options, err) || !ffp_need(own.pattern, "pattern", err))
        return false;
    return ffp_call_run(context, into_files, &call, err);
}
