// A start without a prediction: points in the visual hull.
#include "base/arena.h"
#include "base/device.h"
#include "base/log.h"
#include "base/rng.h"
#include "base/vec.h"
#include "refine/neighbours.h"
#include "refine/refine.h"

#include <stdlib.h>

#define NEAREST 3
#define TRIES 1000 // points drawn for one that is wanted, before the hull counts as empty
#define OFTEN 4096 // tries after which the caller is asked whether to go on

// Whether no view that has the point in its picture sees past it.
static bool in_hull(const FfpCapture *capture, const real point[3]) {
    int seen = 0;
    for (int v = 0; v < capture->n_views; v++) {
        const FfpView *view = &capture->views[v];
        real x, y;
        if (ffp_project(&view->camera, point, &x, &y) <= 0) continue;
        if (!(x >= 0 && y >= 0 && x < (real)view->camera.width && y < (real)view->camera.height)) continue;
        seen++;
        if (view->coverage.data[(size_t)y * view->camera.width + (size_t)x] <= 0.5F) return false;
    }
    return seen > 0;
}

static bool draw_points(real *points, const FfpCapture *capture, int64_t count, FfpRng *rng) {
    const FfpTask task = ffp_task("drawing points", count);
    int64_t found = 0;
    for (int64_t tries = 0; found < count && tries < count * TRIES; tries++) {
        if (tries % OFTEN == 0) ffp_task_step(&task, found, NULL);
        real *p = points + 3 * found;
        for (int k = 0; k < 3; k++) p[k] = ffp_rng_range(rng, -1, 1);
        found += ffp_dot3(p, p) <= 1 && in_hull(capture, p);
    }
    ffp_task_end(&task);
    return found == count;
}

static void place_splats(FfpGaussians *g, FfpRng *rng) {
    int64_t *neighbour = ffp_alloc((size_t)g->count, NEAREST * sizeof *neighbour);
    real *squared = ffp_alloc((size_t)g->count, NEAREST * sizeof *squared);
    ffp_neighbours(g->centre, g->count, NEAREST, neighbour, squared);
    for (int64_t i = 0; i < g->count; i++) {
        const real mean = (squared[NEAREST * i] + squared[NEAREST * i + 1] + squared[NEAREST * i + 2]) / 3;
        for (int k = 0; k < 3; k++) {
            g->scale[3 * i + k] = sqrt(fmax(mean, 1e-7F));
            g->albedo[3 * i + k] = 0.5F;
            g->ambient[3 * i + k] = 0.2F;
        }
        real q[4], square = 0;
        for (int k = 0; k < 4; k++) q[k] = (real)ffp_rng_normal(rng), square += q[k] * q[k];
        for (int k = 0; k < 4; k++) g->rotation[4 * i + k] = square > 0 ? q[k] / sqrt(square) : k == 0;
        g->opacity[i] = 0.1F;
        g->roughness[i] = 0.5F;
    }
    ffp_free(neighbour);
    ffp_free(squared);
}

static bool check(const FfpCapture *capture, int64_t count, FfpError *err) {
    if (ffp_device())
        return ffp_fail(err, FFP_ERROR_UNSUPPORTED, capture->folder,
                        "Gaussians from nothing are made on the CPU only");
    if (count <= NEAREST)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, capture->folder, "%lld points are too few to start from",
                        (long long)count);
    return true;
}

bool ffp_scratch_cube(FfpGaussians *gaussians, const FfpCapture *capture, int64_t count, uint64_t seed,
                      FfpError *err) {
    FfpRng rng = ffp_rng(seed, 4);
    if (!check(capture, count, err)) return false;
    *gaussians = ffp_gaussians_new(count);
    for (int64_t i = 0; i < 3 * count; i++) gaussians->centre[i] = ffp_rng_range(&rng, -1.3F, 1.3F);
    place_splats(gaussians, &rng);
    return true;
}

bool ffp_scratch_gaussians(FfpGaussians *gaussians, const FfpCapture *capture, int64_t count, uint64_t seed,
                           FfpError *err) {
    FfpRng rng = ffp_rng(seed, 3);
    if (!check(capture, count, err)) return false;
    *gaussians = ffp_gaussians_new(count);
    if (!draw_points(gaussians->centre, capture, count, &rng)) {
        ffp_gaussians_free(gaussians);
        return ffp_fail(err, FFP_ERROR_ARGUMENT, capture->folder,
                        "the views' silhouettes have no room for an object in common");
    }
    place_splats(gaussians, &rng);
    return true;
}
