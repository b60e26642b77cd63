// reconstruct CAPTURE FILE.ply: from pixels in memory to relightable Gaussians in a file.
//
// The pixels are taken from a capture folder here, so that the example has something to show; a program of
// yours would take them from its cameras. What counts is fill(): numbers and pointers, no files.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "ffprocams.h"

enum { MOST = 64 };

typedef struct Rig {
    FfpPatternData patterns[MOST];
    FfpViewData views[MOST];
    FfpPicture photographs[MOST][MOST];
    FfpCaptureData data;
} Rig;

static void fill(Rig *rig, const FfpCapture *from) {
    FfpCaptureData *data = &rig->data;
    *data = (FfpCaptureData){.name = "from_memory", .patterns = rig->patterns, .views = rig->views};
    for (; data->n_patterns < ffp_capture_patterns(from) && data->n_patterns < MOST; data->n_patterns++) {
        const int p = data->n_patterns;
        const char *name = ffp_capture_pattern_name(from, p);
        rig->patterns[p] = (FfpPatternData){name, ffp_capture_picture(from, -1, p), false};
        if (strcmp(name, "all_black") == 0) data->black = p;
        if (strcmp(name, "all_white") == 0) data->white = p;
    }
    for (; data->n_views < ffp_capture_views(from) && data->n_views < MOST; data->n_views++) {
        const int v = data->n_views;
        FfpViewData *view = &rig->views[v];
        view->id = ffp_capture_view_id(from, v);
        ffp_capture_view_devices(from, v, &view->camera, &view->projector);
        for (int p = 0; p < data->n_patterns; p++) rig->photographs[v][p] = ffp_capture_picture(from, v, p);
        view->photographs = rig->photographs[v];
        view->mask = ffp_capture_coverage(from, v), view->masked = true;
    }
    ffp_capture_intensity(from, data->intensity);
}

int main(int argc, char **argv) {
    FfpError err = {0};
    if (argc != 3) {
        fprintf(stderr, "usage: reconstruct CAPTURE FILE.ply\n");
        return 2;
    }
    static Rig rig;
    FfpCapture *folder = ffp_capture_open(NULL, argv[1], &err);
    if (folder) fill(&rig, folder);
    FfpCapture *capture = folder ? ffp_capture_from_memory(NULL, &rig.data, &err) : NULL;
    ffp_capture_close(folder);
    FfpModel *model = capture ? ffp_model_open(NULL, NULL, &err) : NULL;
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
