#include "core/capture/uploaded.h"
#include "core/base/arena.h"
#include "core/base/device.h"

static void upload(FfpImage *image) {
    const size_t pixels = (size_t)image->width * (size_t)image->height;
    image->data = ffp_memory_uploaded(image->data, pixels * (size_t)image->channels, sizeof(real));
}

static FfpView view_uploaded(const FfpView *host, int n_patterns) {
    FfpView view = *host;
    view.images = ffp_alloc((size_t)n_patterns, sizeof *view.images);
    for (int p = 0; p < n_patterns; p++) {
        view.images[p] = host->images[p];
        upload(&view.images[p]);
    }
    FfpImage *maps[] = {&view.coverage, &view.depth,     &view.normal,
                        &view.albedo,   &view.roughness, &view.direct_white};
    for (size_t i = 0; i < sizeof maps / sizeof *maps; i++) upload(maps[i]);
    return view;
}

FfpCapture ffp_capture_uploaded(const FfpCapture *host) {
    FfpCapture capture = *host;
    capture.files = NULL;
    capture.views = ffp_alloc((size_t)host->n_views, sizeof *capture.views);
    capture.patterns = ffp_alloc((size_t)host->n_patterns, sizeof *capture.patterns);
    for (int v = 0; v < host->n_views; v++)
        capture.views[v] = view_uploaded(&host->views[v], host->n_patterns);
    for (int p = 0; p < host->n_patterns; p++) {
        capture.patterns[p] = host->patterns[p];
        upload(&capture.patterns[p].image);
    }
    return capture;
}
