// Gaussians fitted to a capture's pictures.
#include "engine/pipeline/refine.h"
#include "core/base/call.h"
#include "product/api/arguments.h"
#include "rig/checks/checks.h"

FfpRefinement ffp_refinement_defaults(void) {
    return (FfpRefinement){.seconds = FFP_REFINE_SECONDS, .noise = FFP_NOISE_ESTIMATED};
}

typedef struct Call {
    FfpGaussians *gaussians;
    const FfpCapture *capture;
    const FfpRefinement *options;
    FfpRefinementStats *stats;
} Call;

static bool work(void *argument, FfpError *err) {
    const Call *call = argument;
    if (!call->options->force && !ffp_rig_suspect(call->capture, err)) return false;
    return ffp_refinement_run(call->gaussians, call->capture, call->options, call->stats, err);
}

bool ffp_refine_gaussians(FfpContext *context, FfpGaussians *gaussians, const FfpCapture *capture,
                          const FfpRefinement *options, FfpRefinementStats *stats, FfpError *err) {
    Call call = {.gaussians = gaussians, .capture = capture, .options = options, .stats = stats};
    if (!ffp_need_gaussians(gaussians, err) || !ffp_need_photographs(capture, err) ||
        !ffp_need(options, "options", err) || !ffp_check_drawing(options->drawing, err))
        return false;
    return ffp_call_run(context, work, &call, err);
}
