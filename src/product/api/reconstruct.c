// Gaussians of a capture.
#include "engine/pipeline/reconstruct.h"
#include <math.h>
#include "core/base/call.h"
#include "core/capture/reduce.h"
#include "product/api/arguments.h"
#include "rig/checks/checks.h"
#include "rig/findings/tell.h"

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

// A draft is made from narrower pictures.
static FfpGaussians *make(const Call *call, FfpError *err) {
    const int64_t width = call->options->width;
    if (width <= 0 || width >= ffp_capture_widest(call->capture))
        return ffp_reconstruction_run(call->capture, call->options, call->stats, err);
    FfpCapture narrow = ffp_capture_narrowed(call->capture, (int)width);
    FfpGaussians *gaussians = ffp_reconstruction_run(&narrow, call->options, call->stats, err);
    ffp_capture_reduced_free(&narrow);
    return gaussians;
}

#define GOOD 27 // dB on unseen patterns, where lit

static void tell_of_unseen(const FfpReconstructionStats *stats) {
    const double figure = stats->unseen_lit_psnr, limit = ffp_rule(FFP_RULE_UNSEEN_BADLY)->limit;
    if (!isfinite(figure)) return;
    ffp_tell(figure < limit ? FFP_RULE_UNSEEN_BADLY : FFP_RULE_UNSEEN,
             &(FfpFacts){.figure = figure,
                         .a = figure < limit  ? "poor"
                              : figure < GOOD ? "fair"
                                              : "good"});
}

// Both kinds are scored on the capture's own pictures, so that their numbers can be compared.
static bool work(void *argument, FfpError *err) {
    Call *call = argument;
    if (!call->options->force && !ffp_rig_suspect(call->capture, err)) return false;
    call->gaussians = make(call, err);
    if (!call->gaussians || !call->stats) return call->gaussians != NULL;
    if (ffp_reconstruction_score(call->gaussians, call->capture, call->options, call->stats, err)) {
        tell_of_unseen(call->stats);
        return true;
    }
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
