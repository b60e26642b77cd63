#include "rig/small.h"

#include <math.h>
#include <stdlib.h>

#include "base/arena.h"

#define SIDE_MAX 176 // pixels

static void shrink_camera(FfpCamera *camera, int width, int height) {
    const real x = (real)width / (real)camera->width, y = (real)height / (real)camera->height;
    camera->fx *= x, camera->cx *= x, camera->fy *= y, camera->cy *= y;
    camera->width = width, camera->height = height;
}

FfpCapture ffp_small_new(const FfpCapture *capture, int active) {
    FfpCapture out = *capture;
    const FfpCamera *camera = &capture->views[0].camera;
    const double shrink = fmin(1, (double)SIDE_MAX / fmax(camera->width, camera->height));
    const int width = (int)fmax(8, round(camera->width * shrink)),
              height = (int)fmax(8, round(camera->height * shrink));
    const int kept[3] = {capture->black, capture->white, active};
    out.views = ffp_alloc((size_t)out.n_views, sizeof *out.views);
    for (int v = 0; v < out.n_views; v++) {
        FfpView *view = &out.views[v];
        view->camera = capture->views[v].camera, view->projector = capture->views[v].projector;
        shrink_camera(&view->camera, width, height);
        view->coverage = ffp_image_resize(&capture->views[v].coverage, width, height);
        view->images = ffp_alloc((size_t)out.n_patterns, sizeof *view->images);
        for (int k = 0; k < 3; k++)
            view->images[kept[k]] = ffp_image_resize(&capture->views[v].images[kept[k]], width, height);
    }
    return out;
}

void ffp_small_free(FfpCapture *small) {
    for (int v = 0; v < small->n_views; v++) {
        ffp_image_free(&small->views[v].coverage);
        for (int p = 0; p < small->n_patterns; p++) ffp_image_free(&small->views[v].images[p]);
        free(small->views[v].images);
    }
    free(small->views);
    *small = (FfpCapture){0};
}
