// Better poses for a capture in its own units.
#include "engine/pipeline/align.h"
#include <string.h>
#include "core/base/log.h"
#include "core/capture/pad.h"
#include "engine/align/align.h"
#include "engine/denoise/denoise.h"
#include "engine/pipeline/normalised.h"

#define DEGREES 57.29577951308232
#define FOCAL_ERROR 0.01 // expected of focal lengths, a share

// The device's lens and turn as they are; its place from the unit sphere back to the world.
static void take_pose(const FfpCamera *from, const FfpCapture *world, FfpCamera *to) {
    memcpy(to->pose, from->pose, sizeof to->pose);
    to->fx = from->fx;
    to->fy = from->fy;
    for (int k = 0; k < 3; k++)
        to->pose[4 * k + 3] = world->centre[k] + world->radius * from->pose[4 * k + 3];
}

static void tell(FfpAlignmentStats *stats, const FfpAlignReport *done, double seconds) {
    *stats = (FfpAlignmentStats){.turntable = done->turntable,
                                 .evened = DEGREES * done->evened,
                                 .depth = DEGREES * done->depth,
                                 .across = DEGREES * done->across,
                                 .side = DEGREES * done->side,
                                 .own = done->own,
                                 .turned = DEGREES * done->turned,
                                 .off = {done->off[0], done->off[1]},
                                 .apart = {done->apart[0], done->apart[1]},
                                 .focal = {done->camera, done->projector},
                                 .before = done->before,
                                 .after = done->after,
                                 .elapsed_s = seconds};
}

bool ffp_alignment_run(FfpCapture *capture, const FfpAlignment *options, FfpAlignmentStats *stats,
                       FfpError *err) {
    const int active = ffp_capture_active_pattern(capture, options->pattern, err);
    if (active < 0) return false;
    const double begin = ffp_seconds();
    FfpAlignSettings settings = ffp_align_defaults();
    if (options->focal_lengths) settings.focal = FOCAL_ERROR;
    FfpCapture normalised = ffp_normalised_alias(capture);
    const int photographs[FFP_PHOTOGRAPHS] = {capture->black, capture->white, active};
    double noise = FFP_NOISE_ESTIMATED;
    FfpImage *clean = ffp_denoise_capture(&normalised, photographs, FFP_PHOTOGRAPHS, &noise);
    FfpCapture padded = ffp_padded_capture(&normalised, photographs, FFP_PHOTOGRAPHS, 1);
    FfpAlignReport done;
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
