#include "engine/refine/reduce.h"
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/integer.h"
#include "core/capture/reduce.h"

#define MARGIN 16 // reduced pixels around the object: what sticks out of it must be seen to do so

// Part of a picture.
typedef struct Window {
    int x0, y0, x1, y1; // the last ones not included
} Window;

// The part of the frame that holds the object, with a margin; one pixel if nothing does.
static Window object_window(const FfpView *view) {
    const FfpImage *coverage = &view->coverage;
    Window w = {coverage->width, coverage->height, 0, 0};
    for (int y = 0; y < coverage->height; y++)
        for (int x = 0; x < coverage->width; x++) {
            if (!(coverage->data[(size_t)y * coverage->width + x] > 0)) continue;
            w.x0 = ffp_smaller(w.x0, x);
            w.x1 = ffp_larger(w.x1, x + 1);
            w.y0 = ffp_smaller(w.y0, y);
            w.y1 = ffp_larger(w.y1, y + 1);
        }
    if (w.x1 == 0) return (Window){0, 0, 1, 1};
    return (Window){ffp_larger(w.x0 - MARGIN, 0), ffp_larger(w.y0 - MARGIN, 0),
                    ffp_smaller(w.x1 + MARGIN, ffp_frame_width(view)),
                    ffp_smaller(w.y1 + MARGIN, ffp_frame_height(view))};
}

static void cut_image(FfpImage *image, const Window *w) {
    if (!image->data) return;
    FfpImage out = ffp_image_new(w->x1 - w->x0, w->y1 - w->y0, image->channels);
    const size_t row = (size_t)out.width * (size_t)out.channels;
    for (int y = 0; y < out.height; y++)
        memcpy(out.data + (size_t)y * row,
               image->data +
                   ((size_t)(y + w->y0) * (size_t)image->width + (size_t)w->x0) * (size_t)out.channels,
               row * sizeof *out.data);
    ffp_image_free(image);
    *image = out;
}

static void cut(FfpView *view, int n_patterns, const Window *w) {
    FfpCamera *camera = &view->camera;
    camera->cx -= (real)w->x0;
    camera->cy -= (real)w->y0;
    camera->width = w->x1 - w->x0;
    camera->height = w->y1 - w->y0;
    view->frame_width = view->frame_height = 0;
    cut_image(&view->coverage, w);
    cut_image(&view->correspondence, w);
    for (int p = 0; p < n_patterns; p++) cut_image(&view->images[p], w);
}

// To the given size, as far as the frame goes.
static Window grown(Window w, const FfpView *view, int width, int height) {
    const int across = ffp_frame_width(view), down = ffp_frame_height(view);
    w.x0 = ffp_larger(ffp_smaller(w.x0, across - width), 0);
    w.y0 = ffp_larger(ffp_smaller(w.y0, down - height), 0);
    return (Window){w.x0, w.y0, ffp_smaller(w.x0 + width, across), ffp_smaller(w.y0 + height, down)};
}

// One size for all views where frames allow it: nothing is then allocated again from view to view.
static void cut_views(FfpCapture *capture) {
    Window *windows = ffp_alloc((size_t)capture->n_views, sizeof *windows);
    int width = 1, height = 1;
    for (int v = 0; v < capture->n_views; v++) {
        const Window w = windows[v] = object_window(&capture->views[v]);
        width = ffp_larger(width, w.x1 - w.x0);
        height = ffp_larger(height, w.y1 - w.y0);
    }
    for (int v = 0; v < capture->n_views; v++) {
        const Window w = grown(windows[v], &capture->views[v], width, height);
        cut(&capture->views[v], capture->n_patterns, &w);
    }
    ffp_free(windows);
}

FfpCapture ffp_reduced(const FfpCapture *capture, const int *patterns, int n_patterns, int side) {
    FfpCapture out = *capture;
    out.views = ffp_alloc((size_t)capture->n_views, sizeof *out.views);
    for (int v = 0; v < capture->n_views; v++) {
        const FfpView *view = &capture->views[v];
        out.views[v] =
            ffp_view_reduced(view, capture->n_patterns, patterns, n_patterns,
                             (view->camera.width + side - 1) / side, (view->camera.height + side - 1) / side);
    }
    cut_views(&out);
    return out;
}
