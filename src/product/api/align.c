// Better poses for a capture, and those of another projector.
#include "engine/pipeline/align.h"
#include "core/base/call.h"
#include "engine/pipeline/found_projector.h"
#include "engine/pipeline/register.h"
#include "product/api/arguments.h"

void ffp_alignment_defaults_into(FfpAlignment *options, size_t size) {
    ffp_give_defaults(options, size, &(FfpAlignment){0}, sizeof(FfpAlignment));
}

typedef struct Call {
    FfpCapture *capture;
    const FfpAlignment *options;
    FfpAlignmentStats *stats;
} Call;

static bool work(void *argument, FfpError *err) {
    const Call *call = argument;
    if (call->options->gaussians) {
        const char *name = call->options->pattern;
        const int pattern = name ? ffp_capture_find_pattern(call->capture, name) : -1;
        if (name && pattern < 0)
            return ffp_fail(err, FFP_ERROR_ARGUMENT, call->capture->folder, "no pattern is called \"%s\"",
                            name);
        for (int v = 0; pattern >= 0 && v < call->capture->n_views; v++)
            if (!call->capture->views[v].images[pattern].data)
                return ffp_fail(err, FFP_ERROR_ARGUMENT, call->capture->views[v].id,
                                "has no photograph under \"%s\"", name);
        ffp_registration_run(call->capture, call->options->gaussians, pattern, call->stats);
        return true;
    }
    return ffp_alignment_run(call->capture, call->options, call->stats, err);
}

bool ffp_align_poses(FfpContext *context, FfpCapture *capture, const FfpAlignment *options,
                     FfpAlignmentStats *stats, FfpError *err) {
    FfpAlignment own = ffp_alignment_defaults();
    Call call = {capture, &own, stats};
    if (!ffp_need_photographs(capture, err) || !ffp_take_options(&own, options, "FfpAlignment", err))
        return false;
    if (own.gaussians && !ffp_need_gaussians(own.gaussians, err)) return false;
    if (own.gaussians && own.focal_lengths)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "focal_lengths", "are not found from known Gaussians");
    return ffp_call_run(context, work, &call, err);
}

typedef struct FindingCall {
    FfpCapture *capture;
    const FfpGaussians *gaussians;
    FfpFoundProjector *found;
} FindingCall;

static bool find_projector(void *argument, FfpError *err) {
    const FindingCall *call = argument;
    return ffp_found_projector(call->capture, call->gaussians, call->found, err);
}

bool ffp_find_projector(FfpContext *context, FfpCapture *capture, const FfpGaussians *gaussians,
                        FfpFoundProjector *found, FfpError *err) {
    FindingCall call = {capture, gaussians, found};
    return ffp_need_photographs(capture, err) && ffp_need_gaussians(gaussians, err) &&
           ffp_call_run(context, find_projector, &call, err);
}
