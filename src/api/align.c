// Better poses for a capture in its own units.
#include <string.h>
#include "ffprocams.h"
#include "align/align.h"
#include "base/call.h"
#include "base/log.h"
#include "capture/pad.h"
#include "denoise/denoise.h"
#include "api/reconstruct.h"

#define DEGREES 57.29577951308232

// The device's turn as it is; its place from the unit sphere back to the world.
static void take_pose(const FfpCamera *from, const FfpCapture *world, FfpCamera *to) {
    memcpy(to->pose, from->pose, sizeof to->pose);
    for (int k = 0; k < 3; k++)
        to->pose[4 * k + 3] = world->centre[k] + world->radius * from->pose[4 * k + 3];
}

static void tell(FfpAlignStats *stats, const FfpAlignment *done, double seconds) {
    *stats = (FfpAlignStats){.turntable = done->turntable,
                             .evened = DEGREES * done->evened,
                             .depth = DEGREES * done->depth,
                             .across = DEGREES * done->across,
                             .side = DEGREES * done->side,
                             .before = done->before,
                             .after = done->after,
                             .seconds = seconds};
}

static bool align(FfpCapture *capture, const char *pattern, FfpAlignStats *stats, FfpError *err) {
    const int active = ffp_capture_active_pattern(capture, pattern, err);
    if (active < 0) return false;
    const double begin = ffp_seconds();
    const FfpAlignSettings settings = ffp_align_defaults();
    FfpCapture normalised = ffp_normalised_alias(capture);
    const int photographs[FFP_PHOTOGRAPHS] = {capture->black, capture->white, active};
    double noise = FFP_NOISE_ESTIMATED;
    FfpImage *clean = ffp_denoise_capture(&normalised, photographs, FFP_PHOTOGRAPHS, &noise);
    FfpCapture padded = ffp_padded_capture(&normalised, photographs, FFP_PHOTOGRAPHS, 1);
    FfpAlignment done;
    const bool ok = ffp_align(&padded, active, &settings, &done, err);
    for (int v = 0; ok && v < capture->n_views; v++) {
        take_pose(&padded.views[v].camera, capture, &capture->views[v].camera);
        take_pose(&padded.views[v].projector, capture, &capture->views[v].projector);
    }
    if (ok && stats) tell(stats, &done, ffp_seconds() - begin);
    ffp_padded_capture_free(&padded, &normalised);
    ffp_denoise_free(clean, capture, photographs, FFP_PHOTOGRAPHS);
    ffp_normalised_alias_free(&normalised);
    return ok;
}

typedef struct Call {
    FfpCapture *capture;
    const char *pattern;
    FfpAlignStats *stats;
} Call;

static bool work(void *argument, FfpError *err) {
    const Call *call = argument;
    return align(call->capture, call->pattern, call->stats, err);
}

bool ffp_align_poses(FfpContext *context, FfpCapture *capture, const char *pattern, FfpAlignStats *stats,
                     FfpError *err) {
    Call call = {capture, pattern, stats};
    return ffp_call_run(context, work, &call, err);
}
