// Gaussians of a capture.
#include "engine/pipeline/reconstruct.h"
#include "core/base/call.h"
#include "product/api/arguments.h"
#include "rig/checks/checks.h"

FfpReconstruction ffp_reconstruction_defaults(void) {
    return (FfpReconstruction){
        .polish = FFP_POLISH_AUTO, .noise = FFP_NOISE_ESTIMATED, .layers = FFP_LAYERS_AUTO};
}

typedef struct Call {
    const FfpCapture *capture;
    const FfpReconstruction *options;
    FfpReconstructionStats *stats;
    FfpGaussians *gaussians;
} Call;

static bool work(void *argument, FfpError *err) {
    Call *call = argument;
    if (!call->options->force && !ffp_rig_suspect(call->capture, err)) return false;
    call->gaussians = ffp_reconstruction_run(call->capture, call->options, call->stats, err);
    if (!call->gaussians || !call->stats) return call->gaussians != NULL;
    if (ffp_reconstruction_score(call->gaussians, call->capture, call->options, call->stats, err))
        return true;
    ffp_gaussians_close(call->gaussians);
    return false;
}

FfpGaussians *ffp_reconstruct(FfpContext *context, const FfpCapture *capture,
                              const FfpReconstruction *options, FfpReconstructionStats *stats,
                              FfpError *err) {
    Call call = {capture, options, stats, NULL};
    if (!ffp_need_photographs(capture, err) || !ffp_need(options, "options", err) ||
        !ffp_check_drawing(options->drawing, err))
        return NULL;
    return ffp_call_run(context, work, &call, err) ? call.gaussians : NULL;
}
