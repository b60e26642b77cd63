#include "core/capture/uploaded.h"
#include "core/base/arena.h"
#include "core/base/device.h"

static void upload(FfpImage *image) {
    const size_t pixels = (size_t)image->width * (size_t)image->height;
    image->data = ffp_memory_uploaded(image->data, pixels * (size_t)image->channels, sizeof(real));
}

static FfpView view_uploaded(const FfpView *host, int n_patterns, bool truth) {
    FfpView view = *host;
    view.images = ffp_alloc((size_t)n_patterns, sizeof *view.images);
    view.correspondence = (FfpImage){0};
    FfpImage *maps[] = {&view.depth, &view.normal, &view.albedo, &view.roughness, &view.direct_white};
    for (size_t i = 0; i < sizeof maps / sizeof *maps; i++) {
        if (!truth) *maps[i] = (FfpImage){0};
        upload(maps[i]);
    }
    upload(&view.coverage);
    return view;
}

static void upload_pattern(FfpCapture *there, const FfpCapture *host, int p) {
    if (there->patterns[p].image.data) return; // listed twice
    there->patterns[p] = host->patterns[p];
    upload(&there->patterns[p].image);
    for (int v = 0; v < host->n_views; v++) {
        there->views[v].images[p] = host->views[v].images[p];
        upload(&there->views[v].images[p]);
    }
}

FfpCapture ffp_capture_uploaded(const FfpCapture *host, const int *patterns, int n) {
    FfpCapture capture = *host;
    capture.files = NULL;
    capture.views = ffp_alloc((size_t)host->n_views, sizeof *capture.views);
    capture.patterns = ffp_alloc((size_t)host->n_patterns, sizeof *capture.patterns);
    for (int v = 0; v < host->n_views; v++)
        capture.views[v] = view_uploaded(&host->views[v], host->n_patterns, !patterns);
    for (int k = 0; k < (patterns ? n : host->n_patterns); k++)
        upload_pattern(&capture, host, patterns ? patterns[k] : k);
    return capture;
}
