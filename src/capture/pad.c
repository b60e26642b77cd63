#include "capture/pad.h"

#include <stdlib.h>
#include <string.h>
#include "base/arena.h"

static FfpImage padded_image(const FfpImage *image, int width, int height) {
    if (!image->data) return (FfpImage){0};
    FfpImage out = ffp_image_new(width, height, image->channels);
    const size_t from = (size_t)image->width * (size_t)image->channels,
                 to = (size_t)width * (size_t)image->channels;
    for (int y = 0; y < image->height; y++)
        memcpy(out.data + (size_t)y * to, image->data + (size_t)y * from, from * sizeof(real));
    return out;
}

static FfpView padded_view(const FfpView *view, int n_patterns, const int *pictures, int n, int width,
                           int height) {
    FfpView out = {.camera = view->camera,
                   .projector = view->projector,
                   .frame_width = ffp_frame_width(view),
                   .frame_height = ffp_frame_height(view)};
    memcpy(out.id, view->id, sizeof out.id);
    out.camera.width = width, out.camera.height = height;
    out.coverage = padded_image(&view->coverage, width, height);
    out.images = ffp_alloc((size_t)n_patterns, sizeof *out.images);
    for (int p = 0; p < n; p++)
        if (!out.images[pictures[p]].data)
            out.images[pictures[p]] = padded_image(&view->images[pictures[p]], width, height);
    return out;
}

FfpCapture ffp_padded_capture(const FfpCapture *capture, const int *pictures, int n, int multiple) {
    FfpCapture out = *capture;
    int width = 0, height = 0;
    for (int v = 0; v < capture->n_views; v++) {
        const FfpCamera *camera = &capture->views[v].camera;
        width = camera->width > width ? camera->width : width;
        height = camera->height > height ? camera->height : height;
    }
    width = (width + multiple - 1) / multiple * multiple;
    height = (height + multiple - 1) / multiple * multiple;
    out.views = ffp_alloc((size_t)capture->n_views, sizeof *out.views);
    for (int v = 0; v < capture->n_views; v++) {
        const FfpView *view = &capture->views[v];
        const bool fits = view->camera.width == width && view->camera.height == height;
        out.views[v] = fits ? *view : padded_view(view, capture->n_patterns, pictures, n, width, height);
    }
    return out;
}

void ffp_padded_capture_free(FfpCapture *padded, const FfpCapture *capture) {
    for (int v = 0; v < padded->n_views; v++) {
        FfpView *view = &padded->views[v];
        if (view->images == capture->views[v].images) continue;
        for (int p = 0; p < padded->n_patterns; p++) ffp_image_free(&view->images[p]);
        free(view->images);
        ffp_image_free(&view->coverage);
    }
    free(padded->views);
    padded->views = NULL, padded->n_views = 0;
}
