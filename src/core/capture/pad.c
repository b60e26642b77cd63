#include "core/capture/pad.h"
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"

// The upper left part of the picture, with black to the right and below where there is less of it.
static FfpImage reframed_image(const FfpImage *image, int width, int height) {
    if (!image->data) return (FfpImage){0};
    FfpImage out = ffp_image_new(width, height, image->channels);
    const size_t from = (size_t)image->width * (size_t)image->channels,
                 to = (size_t)width * (size_t)image->channels, shared = from < to ? from : to;
    for (int y = 0; y < image->height && y < height; y++)
        memcpy(out.data + (size_t)y * to, image->data + (size_t)y * from, shared * sizeof(real));
    return out;
}

static FfpView padded_view(const FfpView *view, int n_patterns, const int *pictures, int n, int width,
                           int height) {
    FfpView out = {.camera = view->camera,
                   .projector = view->projector,
                   .near = view->near,
                   .far = view->far,
                   .frame_width = ffp_frame_width(view),
                   .frame_height = ffp_frame_height(view)};
    memcpy(out.id, view->id, sizeof out.id);
    out.camera.width = width;
    out.camera.height = height;
    out.coverage = reframed_image(&view->coverage, width, height);
    out.correspondence = reframed_image(&view->correspondence, width, height);
    out.images = ffp_alloc((size_t)n_patterns, sizeof *out.images);
    for (int p = 0; p < n; p++)
        if (!out.images[pictures[p]].data)
            out.images[pictures[p]] = reframed_image(&view->images[pictures[p]], width, height);
    return out;
}

static int rounded_up(int side, int multiple) {
    return (side + multiple - 1) / multiple * multiple;
}

FfpCapture ffp_padded_capture(const FfpCapture *capture, const int *pictures, int n, int multiple) {
    FfpCapture out = *capture;
    int width = 0, height = 0;
    for (int v = 0; v < capture->n_views; v++) {
        const FfpCamera *camera = &capture->views[v].camera;
        width = camera->width > width ? camera->width : width;
        height = camera->height > height ? camera->height : height;
    }
    width = rounded_up(width, multiple);
    height = rounded_up(height, multiple);
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
        ffp_free(view->images);
        ffp_image_free(&view->coverage);
        ffp_image_free(&view->correspondence);
    }
    ffp_free(padded->views);
    padded->views = NULL;
    padded->n_views = 0;
}

FfpCamera ffp_whole_camera(const FfpCamera *camera) {
    FfpCamera out = *camera;
    out.width = rounded_up(camera->width, FFP_WHOLE_PATCH);
    out.height = rounded_up(camera->height, FFP_WHOLE_PATCH);
    return out;
}

// The upper left part, or more than there is.
static void reframe_view(FfpView *out, const FfpView *view, int n_patterns, int width, int height) {
    const FfpImage *const from[] = {&view->coverage, &view->correspondence, &view->depth,       &view->normal,
                                    &view->albedo,   &view->roughness,      &view->direct_white};
    FfpImage *const to[] = {&out->coverage, &out->correspondence, &out->depth,       &out->normal,
                            &out->albedo,   &out->roughness,      &out->direct_white};
    *out = *view;
    out->images = ffp_alloc((size_t)n_patterns, sizeof *out->images);
    for (int p = 0; p < n_patterns; p++) out->images[p] = reframed_image(&view->images[p], width, height);
    for (size_t i = 0; i < sizeof to / sizeof *to; i++) *to[i] = reframed_image(from[i], width, height);
    out->camera.width = width;
    out->camera.height = height;
}

FfpView ffp_whole_view(const FfpView *view, int n_patterns) {
    const FfpCamera whole = ffp_whole_camera(&view->camera);
    FfpView out;
    reframe_view(&out, view, n_patterns, whole.width, whole.height);
    out.frame_width = ffp_frame_width(view);
    out.frame_height = ffp_frame_height(view);
    return out;
}

void ffp_cut_to_frame(FfpView *view, int n_patterns) {
    FfpView out;
    reframe_view(&out, view, n_patterns, ffp_frame_width(view), ffp_frame_height(view));
    out.frame_width = out.frame_height = 0;
    ffp_view_free(view, n_patterns);
    *view = out;
}
