// reconstruct CAPTURE FILE.ply: from pixels in memory to relightable Gaussians in a file.
//
// The pixels are taken from a capture folder here, so that the example has something to show; a program of
// yours would take them from its cameras. The important part is fill(): numbers and pointers, no files.
#include <stdio.h>
#include <stdlib.h>
#include "ffprocams.h"

typedef struct Rig {
    FfpPatternData *patterns;
    FfpViewData *views;
    FfpPicture *photographs; // [views][patterns]
    FfpCaptureData data;
} Rig;

static bool fill(Rig *rig, const FfpCapture *from) {
    const int n_patterns = ffp_capture_patterns(from), n_views = ffp_capture_views(from);
    FfpCaptureData *data = &rig->data;
    rig->patterns = calloc((size_t)n_patterns, sizeof *rig->patterns);
    rig->views = calloc((size_t)n_views, sizeof *rig->views);
    rig->photographs = calloc((size_t)n_views * (size_t)n_patterns, sizeof *rig->photographs);
    if (!rig->patterns || !rig->views || !rig->photographs) return false;
    *data = (FfpCaptureData){.name = "from_memory",
                             .n_patterns = n_patterns,
                             .n_views = n_views,
                             .patterns = rig->patterns,
                             .views = rig->views};
    for (int p = 0; p < n_patterns; p++) {
        const FfpPatternRole role = ffp_capture_pattern_role(from, p);
        rig->patterns[p] = (FfpPatternData){.name = ffp_capture_pattern_name(from, p),
                                            .picture = ffp_capture_picture(from, -1, p),
                                            .held_out = role == FFP_PATTERN_HELD_OUT};
        if (role == FFP_PATTERN_BLACK) data->black = p;
        if (role == FFP_PATTERN_WHITE) data->white = p;
    }
    for (int v = 0; v < n_views; v++) {
        FfpViewData *view = &rig->views[v];
        FfpPicture *photographs = rig->photographs + (size_t)v * (size_t)n_patterns;
        view->id = ffp_capture_view_id(from, v);
        ffp_capture_view_devices(from, v, &view->camera, &view->projector);
        for (int p = 0; p < n_patterns; p++) photographs[p] = ffp_capture_picture(from, v, p);
        view->photographs = photographs;
        view->mask = ffp_capture_coverage(from, v), view->masked = true;
    }
    ffp_capture_intensity(from, data->intensity);
    return true;
}

static FfpCapture *from_memory(const FfpCapture *folder, FfpError *err) {
    Rig rig = {0};
    FfpCapture *capture = NULL;
    if (fill(&rig, folder))
        capture = ffp_capture_from_memory(NULL, &rig.data, err); // which copies all of it
    else
        snprintf(err->text, sizeof err->text, "out of memory");
    free(rig.patterns), free(rig.views), free(rig.photographs);
    return capture;
}

int main(int argc, char **argv) {
    FfpError err = {0};
    if (argc != 3) {
        fprintf(stderr, "usage: reconstruct CAPTURE FILE.ply\n");
        return 2;
    }
    FfpCapture *folder = ffp_capture_open(NULL, argv[1], NULL, &err);
    FfpCapture *capture = folder ? from_memory(folder, &err) : NULL;
    ffp_capture_close(folder);
    FfpModel *model = capture ? ffp_model_open(NULL, NULL, NULL, &err) : NULL;
    FfpReconstruction options = ffp_reconstruction_defaults();
    options.model = model;
    options.polish = 10; // the default takes ten times as long, and is better
    FfpReconstructionStats stats;
    FfpGaussians *gaussians = model ? ffp_reconstruct(NULL, capture, &options, &stats, &err) : NULL;
    const bool done = gaussians && ffp_gaussians_save(NULL, gaussians, argv[2], &err);
    if (done)
        printf("%lld Gaussians from pattern %s\n", (long long)stats.gaussians, stats.pattern);
    else
        fprintf(stderr, "reconstruct: %s\n", err.text);
    ffp_gaussians_close(gaussians);
    ffp_model_close(model);
    ffp_capture_close(capture);
    return done ? 0 : 1;
}
