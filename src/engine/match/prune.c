#include "engine/match/prune.h"
#include <stdlib.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "engine/match/consistency.h"
#include "engine/match/projector_rays.h"
#include "engine/match/reduce.h"

static bool off_silhouette(const FfpView *view, real u, real v) {
    if (!(u >= 0 && v >= 0 && u < (real)ffp_frame_width(view) && v < (real)ffp_frame_height(view)))
        return false;
    return view->coverage.data[(size_t)v * (size_t)view->coverage.width + (size_t)u] <= 0;
}

// A point of view `own`.
static bool contradicted(const FfpSupportViews *support_views, const FfpProjectorRays *projector_rays,
                         const real point[3], int own) {
    const FfpDepths *depths = support_views->depths;
    const FfpAsked *asked = &support_views->asked[own];
    FfpSupport support = {.coverage = 1};
    real x, y;
    for (int v = 0; v < depths->capture->n_views && !depths->capture->scene; v++)
        if (ffp_project(&depths->capture->views[v].camera, point, &x, &y) > 0 &&
            off_silhouette(&depths->capture->views[v], x, y))
            return true;
    for (int k = 0; k < asked->count; k++) {
        const int v = asked->view[k];
        const FfpView *view = &depths->capture->views[v];
        real z = ffp_project(&view->camera, point, &x, &y);
        if (z > 0) {
            const FfpDepthBounds bounds = ffp_depth_bounds_at(support_views, v, x, y);
            ffp_support_count(&support, &bounds, z, FFP_SUPPORT_SLACK * z / view->camera.fx);
        }
        z = ffp_project(&view->projector, point, &x, &y);
        if (!(z > 0)) continue;
        const FfpDepthBounds lit = ffp_projector_rays_at(&projector_rays[v], x, y);
        const real cell = z / (view->projector.fx * projector_rays[v].scale);
        if (z < lit.low - FFP_SUPPORT_SLACK * cell) support.trust_past += lit.trust;
    }
    return ffp_support_is_free_space(&support);
}

int64_t ffp_prune_contradicted(real *opacity, const real *centre, const int64_t *pixel, int64_t count,
                               const FfpCapture *capture, const FfpInitialisation *start) {
    const int64_t own_area = (int64_t)start->width * start->height;
    if (start->reduced) {
        capture = &start->reduced->capture;
        start = &start->reduced->start;
    }
    const size_t area = (size_t)start->width * (size_t)start->height, views = (size_t)start->views;
    FfpDepths depths = {capture, start->width, start->height, ffp_alloc(views * area, sizeof(real)),
                        start->confidence};
    for (size_t i = 0; i < views * area; i++)
        depths.depth[i] = start->footprint[i] * capture->views[i / area].camera.fx;
    FfpSupportViews support_views = ffp_support_views_new(&depths);
    FfpProjectorRays *projector_rays = ffp_alloc(views, sizeof *projector_rays);
    for (size_t v = 0; v < views; v++) projector_rays[v] = ffp_projector_rays_new(&depths, (int)v);
    int64_t n_contradicted = 0;
#pragma omp parallel for schedule(static) reduction(+ : n_contradicted)
    for (int64_t i = 0; i < count; i++) {
        const int own = (int)(pixel[i] / own_area);
        if (opacity[i] > 0 && contradicted(&support_views, projector_rays, centre + 3 * i, own)) {
            opacity[i] = 0;
            n_contradicted++;
        }
    }
    for (size_t v = 0; v < views; v++) ffp_projector_rays_free(&projector_rays[v]);
    ffp_free(projector_rays);
    ffp_free(depths.depth);
    ffp_support_views_free(&support_views);
    return n_contradicted;
}

int64_t ffp_prune_off_silhouettes(real *opacity, const real *centre, int64_t count,
                                  const FfpCapture *capture) {
    int64_t off = 0;
#pragma omp parallel for schedule(static) reduction(+ : off)
    for (int64_t i = 0; i < count; i++) {
        int against = 0;
        for (int v = 0; v < capture->n_views && against < 2 && opacity[i] > 0; v++) {
            real x, y;
            against += ffp_project(&capture->views[v].camera, centre + 3 * i, &x, &y) > 0 &&
                       off_silhouette(&capture->views[v], x, y);
        }
        if (against < 2) continue;
        opacity[i] = 0;
        off++;
    }
    return off;
}
