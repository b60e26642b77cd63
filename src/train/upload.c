// Scenes brought to a device.
#include <stdlib.h>
#include "base/arena.h"
#include "base/device.h"
#include "capture/uploaded.h"
#include "train/mirror.h"

// True distance of each Gaussian's pixel.
static real *upload_distances(const FfpScene *scene, const FfpPrepared *prepared) {
    const int64_t count = ffp_prepared_count(prepared), *pixel = ffp_prepared_pixels(prepared);
    real *truth = ffp_alloc((size_t)count + 1, sizeof *truth);
    ffp_scene_distances(truth, scene, pixel, count);
    real *there = ffp_memory_uploaded(truth, (size_t)count + 1, sizeof *truth);
    free(truth);
    return there;
}

bool ffp_scene_upload(FfpScene *there, const FfpScene *scene, const FfpTrainConfig *config, FfpError *err) {
    const FfpCapture *capture = &scene->capture;
    *there = (FfpScene){0};
    FfpPrepared *prepared =
        ffp_prepared_new(&config->model, &scene->inputs, &scene->start, &scene->context, scene->active, err);
    if (!prepared) return false;
    *there =
        (FfpScene){.capture = ffp_capture_uploaded(capture), .active = scene->active, .prepared = prepared};
    there->true_t = upload_distances(scene, there->prepared);
    there->patterns = ffp_alloc((size_t)capture->n_patterns, sizeof *there->patterns);
    for (int p = 0; p < capture->n_patterns; p++)
        there->patterns[p] = ffp_summed_uploaded(&scene->patterns[p]);
    there->inputs = there->capture;
    there->inputs.n_views = scene->inputs.n_views;
    return true;
}

void ffp_scene_upload_free(FfpScene *there) {
    if (!there->prepared) return;
    for (int p = 0; p < there->capture.n_patterns; p++) ffp_summed_free(&there->patterns[p]);
    free(there->patterns);
    ffp_capture_free(&there->capture);
    ffp_memory_free(there->true_t);
    ffp_prepared_free(there->prepared);
    *there = (FfpScene){0};
}
