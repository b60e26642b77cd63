// Gaussians fitted to a capture's pictures.
#include "engine/pipeline/refine.h"
#include "core/base/call.h"
#include "product/api/arguments.h"
#include "rig/checks/checks.h"

void ffp_refinement_defaults_into(FfpRefinement *options, size_t size) {
    ffp_give_defaults(options, size, &(FfpRefinement){.noise = FFP_NOISE_ESTIMATED}, sizeof(FfpRefinement));
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
    FfpRefinement own = ffp_refinement_defaults();
    Call call = {.gaussians = gaussians, .capture = capture, .options = &own, .stats = stats};
    if (!ffp_need_gaussians(gaussians, err) || !ffp_need_photographs(capture, err) ||
        !ffp_take_options(&own, options, "FfpRefinement", err) || !ffp_check_refinement(&own, err))
        return false;
    return ffp_call_run(context, work, &call, err);
}
