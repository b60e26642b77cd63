// A capture whose pictures are smaller, as cameras with fewer pixels would have taken them.
#include "capture/reduce.h"

#include <stdlib.h>
#include <string.h>
#include <tgmath.h>
#include "base/arena.h"

static void reduce_camera(FfpCamera *camera, int width, int height) {
    const real x = (real)width / (real)camera->width, y = (real)height / (real)camera->height;
    camera->fx *= x, camera->cx *= x, camera->fy *= y, camera->cy *= y;
    camera->width = width, camera->height = height;
}

// Picture over black -> coverage times the object's own linear radiance, averaged -> picture over black.
static FfpImage reduce_photograph(const FfpImage *shown, const FfpImage *coverage,
                                  const FfpImage *coverage_out) {
    if (coverage_out->width == shown->width && coverage_out->height == shown->height)
        return ffp_image_copy(shown);
    FfpImage light = ffp_image_new(shown->width, shown->height, 3);
    const size_t pixels = (size_t)shown->width * (size_t)shown->height,
                 pixels_out = (size_t)coverage_out->width * (size_t)coverage_out->height;
#pragma omp parallel for schedule(static)
    for (size_t i = 0; i < pixels; i++) {
        const real share = coverage->data[i];
        if (share <= 0) continue;
        ffp_own_radiance(light.data + 3 * i, shown->data + 3 * i, share);
        for (int c = 0; c < 3; c++) light.data[3 * i + c] *= share;
    }
    FfpImage out = ffp_image_resize(&light, coverage_out->width, coverage_out->height);
    ffp_image_free(&light);
#pragma omp parallel for schedule(static)
    for (size_t i = 0; i < pixels_out; i++)
        ffp_shown_radiance(out.data + 3 * i, out.data + 3 * i, coverage_out->data[i]);
    return out;
}

// Pixels of a side that hold a frame's.
static int frame_side(int frame, int side, int side_out) {
    return frame == side ? 0 : (int)ceil((double)frame * side_out / side);
}

FfpView ffp_view_reduced(const FfpView *view, int n_patterns, const int *patterns, int n, int width,
                         int height) {
    FfpView out = {.camera = view->camera, .projector = view->projector};
    memcpy(out.id, view->id, sizeof out.id);
    reduce_camera(&out.camera, width, height);
    out.frame_width = frame_side(ffp_frame_width(view), view->camera.width, width);
    out.frame_height = frame_side(ffp_frame_height(view), view->camera.height, height);
    out.coverage = ffp_image_resize(&view->coverage, width, height);
    out.images = ffp_alloc((size_t)n_patterns, sizeof *out.images);
    for (int k = 0; k < n; k++) {
        FfpImage *image = &out.images[patterns[k]];
        if (view->images[patterns[k]].data && !image->data)
            *image = reduce_photograph(&view->images[patterns[k]], &view->coverage, &out.coverage);
    }
    return out;
}

void ffp_view_reduced_free(FfpView *view, int n_patterns) {
    ffp_image_free(&view->coverage);
    for (int p = 0; view->images && p < n_patterns; p++) ffp_image_free(&view->images[p]);
    ffp_free(view->images);
    view->images = NULL;
}

FfpCapture ffp_capture_reduced(const FfpCapture *capture, int views, const int *patterns, int n, int width,
                               int height) {
    FfpCapture out = *capture;
    out.n_views = views;
    out.views = ffp_alloc((size_t)views, sizeof *out.views);
    for (int v = 0; v < views; v++)
        out.views[v] = ffp_view_reduced(&capture->views[v], capture->n_patterns, patterns, n, width, height);
    return out;
}

void ffp_capture_reduced_free(FfpCapture *reduced) {
    for (int v = 0; v < reduced->n_views; v++) ffp_view_reduced_free(&reduced->views[v], reduced->n_patterns);
    ffp_free(reduced->views);
    reduced->views = NULL, reduced->n_views = 0;
}
