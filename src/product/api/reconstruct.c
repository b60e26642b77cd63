// Gaussians of a capture.
#include "engine/pipeline/reconstruct.h"
#include "core/base/call.h"
#include "product/api/arguments.h"
#include "rig/checks/checks.h"

void ffp_reconstruction_defaults_into(FfpReconstruction *options, size_t size) {
    ffp_give_defaults(options, size,
                      &(FfpReconstruction){
                          .polish = FFP_POLISH_AUTO, .noise = FFP_NOISE_ESTIMATED, .layers = FFP_LAYERS_AUTO},
                      sizeof(FfpReconstruction));
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
    FfpReconstruction own = ffp_reconstruction_defaults();
    Call call = {capture, &own, stats, NULL};
    if (!ffp_need_photographs(capture, err) || !ffp_take_options(&own, options, "FfpReconstruction", err) ||
        !ffp_check_reconstruction(&own, err))
        return NULL;
    return ffp_call_run(context, work, &call, err) ? call.gaussians : NULL;
}
