// Better poses for a capture.
#include "engine/pipeline/align.h"
#include "core/base/call.h"
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
    return ffp_alignment_run(call->capture, call->options, call->stats, err);
}

bool ffp_align_poses(FfpContext *context, FfpCapture *capture, const FfpAlignment *options,
                     FfpAlignmentStats *stats, FfpError *err) {
    Call call = {capture, options, stats};
    if (!ffp_need(capture, "capture", err) || !ffp_need(options, "options", err)) return false;
    return ffp_call_run(context, work, &call, err);
}
