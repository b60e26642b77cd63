// Better poses for a capture.
#include "engine/pipeline/align.h"
#include "core/base/call.h"
#include "engine/pipeline/register.h"
#include "product/api/arguments.h"

FfpAlignment ffp_alignment_defaults(void) {
    return (FfpAlignment){0};
}

typedef struct Call {
    FfpCapture *capture;
    const FfpAlignment *options;
    FfpAlignmentStats *stats;
} Call;

static bool work(void *argument, FfpError *err) {
    const Call *call = argument;
    if (call->options->gaussians) {
        ffp_registration_run(call->capture, call->options->gaussians, call->stats);
        return true;
    }
    return ffp_alignment_run(call->capture, call->options, call->stats, err);
}

bool ffp_align_poses(FfpContext *context, FfpCapture *capture, const FfpAlignment *options,
                     FfpAlignmentStats *stats, FfpError *err) {
    Call call = {capture, options, stats};
    if (!ffp_need_photographs(capture, err) || !ffp_need(options, "options", err)) return false;
    if (options->gaussians && !ffp_need_gaussians(options->gaussians, err)) return false;
    if (options->gaussians && options->focal_lengths)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, "focal_lengths", "are not found from known Gaussians");
    return ffp_call_run(context, work, &call, err);
}
