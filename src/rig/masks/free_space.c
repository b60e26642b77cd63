#include "rig/masks/free_space.h"
#include <tgmath.h>
#include "core/base/alloc.h"
#include "core/capture/reduce.h"
#include "core/capture/small.h"
#include "engine/match/match.h"
#include "rig/masks/limits.h"

enum { SIDE = 160 }; // cells of a projector's map

// A small capture over black, normalised; the pattern's own memory is the capture's.
static FfpCapture masked_copy(const FfpCapture *capture, int active) {
    FfpCapture small = ffp_small_new(capture, active);
    const FfpCamera *full = &capture->views[0].camera;
    for (int v = 0; v < small.n_views; v++) {
        FfpView *view = &small.views[v];
        if (view->camera.width != full->width || view->camera.height != full->height) continue;
        for (int p = 0; p < small.n_patterns; p++) ffp_mask_apply(&view->coverage, &view->images[p]);
    }
    ffp_capture_normalise(&small, capture->centre, capture->radius);
    return small;
}

static bool is_sure(const FfpInitialisation *found, size_t at) {
    return (double)found->confidence[at] > FREE_CONFIDENCE &&
           (double)found->violation[at] <= FREE_VIOLATION && (double)found->coverage[at] > FREE_COVERED;
}

// Puts the nearest surfaces of one view's camera and projector, of the depths that are sure.
static void put_view(FfpFreeSpace *space, int v, const FfpInitialisation *found, const FfpCapture *small,
                     const FfpCapture *capture) {
    const FfpCamera *camera = &small->views[v].camera;
    const size_t pixels = (size_t)found->width * (size_t)found->height;
    for (size_t i = 0; i < pixels; i++) {
        const size_t at = (size_t)v * pixels + i;
        real d[3], point[3];
        if (!is_sure(found, at)) continue;
        ffp_pixel_ray(camera, (real)(i % (size_t)found->width) + 0.5F,
                      (real)(i / (size_t)found->width) + 0.5F, d);
        for (int k = 0; k < 3; k++)
            point[k] = capture->centre[k] + capture->radius * (camera->pose[4 * k + 3] + found->t[at] * d[k]);
        ffp_depth_map_put(&space->cameras[v], point, 0);
        ffp_depth_map_put(&space->projectors[v], point, 0);
    }
}

static bool same_sizes(const FfpCapture *capture) {
    for (int v = 1; v < capture->n_views; v++)
        if (capture->views[v].camera.width != capture->views[0].camera.width ||
            capture->views[v].camera.height != capture->views[0].camera.height)
            return false;
    return true;
}

bool ffp_free_space_new(FfpFreeSpace *space, const FfpCapture *capture) {
    const FfpMatchSettings settings = ffp_match_defaults();
    const int active = ffp_capture_active_pattern(capture, NULL, NULL), n = capture->n_views;
    FfpInitialisation found;
    *space = (FfpFreeSpace){0};
    if (active < 0 || !same_sizes(capture)) return false;
    FfpCapture small = masked_copy(capture, active);
    const bool ok = ffp_initialisation_new(&found, &small, &active, 1, &settings, NULL);
    if (ok) {
        *space = (FfpFreeSpace){n, ffp_alloc((size_t)n, sizeof *space->cameras),
                                ffp_alloc((size_t)n, sizeof *space->projectors)};
        for (int v = 0; v < n; v++) {
            space->cameras[v] = ffp_depth_map_new(&capture->views[v].camera, found.width, found.height);
            space->projectors[v] = ffp_depth_map_new(&capture->views[v].projector, SIDE, SIDE);
            put_view(space, v, &found, &small, capture);
        }
        ffp_initialisation_free(&found);
    }
    ffp_capture_reduced_free(&small);
    return ok;
}

void ffp_free_space_free(FfpFreeSpace *space) {
    for (int v = 0; v < space->n_views; v++)
        ffp_depth_map_free(&space->cameras[v]), ffp_depth_map_free(&space->projectors[v]);
    ffp_free(space->cameras), ffp_free(space->projectors);
    *space = (FfpFreeSpace){0};
}

static int sees_through(const FfpDepthMap *map, const real point[3], real margin) {
    int cell;
    real z;
    if (!ffp_depth_map_find(map, point, &cell, &z)) return 0;
    const real surface = ffp_depth_map_around(map, cell);
    return isfinite(surface) && z < surface - margin;
}

int ffp_free_space_votes(const FfpFreeSpace *space, int view, const real point[3], real margin) {
    if (space->n_views == 0) return 0;
    return sees_through(&space->cameras[view], point, margin) +
           sees_through(&space->projectors[view], point, margin);
}
