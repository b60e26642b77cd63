// Scenes brought to a device.
#include <stdlib.h>
#include "core/base/arena.h"
#include "core/base/device.h"
#include "core/capture/uploaded.h"
#include "lab/train/mirror.h"

void ffp_scene_upload(FfpScene *there, const FfpScene *scene) {
    const FfpCapture *capture = &scene->capture;
    const size_t count = (size_t)ffp_prepared_count(scene->prepared);
    *there = (FfpScene){.capture = ffp_capture_uploaded(capture, NULL, 0),
                        .borrowed = scene->borrowed,
                        .active = scene->active,
                        .targets_only = scene->targets_only,
                        .prepared = ffp_prepared_uploaded(scene->prepared),
                        .true_t = ffp_memory_uploaded(scene->true_t, count + 1, sizeof *scene->true_t)};
    there->patterns = ffp_alloc((size_t)capture->n_patterns, sizeof *there->patterns);
    for (int p = 0; p < capture->n_patterns; p++)
        there->patterns[p] = ffp_summed_uploaded(&scene->patterns[p]);
    // A borrowed scene's inputs are pictures of their own: filtered, and padded.
    there->inputs = scene->borrowed ? ffp_capture_uploaded(&scene->inputs, NULL, 0) : there->capture;
    there->inputs.n_views = scene->inputs.n_views;
}

void ffp_scene_upload_free(FfpScene *there) {
    if (!there->prepared) return;
    for (int p = 0; p < there->capture.n_patterns; p++) ffp_summed_free(&there->patterns[p]);
    ffp_free(there->patterns);
    if (there->borrowed) ffp_capture_free(&there->inputs);
    ffp_capture_free(&there->capture);
    ffp_memory_free(there->true_t);
    ffp_prepared_free(there->prepared);
    *there = (FfpScene){0};
}
