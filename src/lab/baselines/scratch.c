// A fit without a prediction: points, in the visual hull or given, which adaptive density turns into a
// surface.
#include "lab/baselines/scratch.h"
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/call.h"
#include "core/base/device.h"
#include "core/base/log.h"
#include "core/base/rng.h"
#include "core/base/vec.h"
#include "engine/refine/neighbours.h"

#define NEAREST 3
#define TRIES 1000 // points drawn for one that is wanted, before the hull counts as empty
#define OBJECT_EXTENT 4
#define OFTEN 4096 // tries after which the caller is asked whether to go on

// Rates and densification of GS-ProCams' released program, whose scene extent is 1.1 times the cameras'
// distance from their mean: about 4 in the unit sphere's units. Its distortion is a square of a depth
// compressed to 1 - 0.2 / z; its weight of 1000 there is about this one here for layers 0.02 apart.
FfpScratchSettings ffp_scratch_defaults(bool released) {
    const real extent = OBJECT_EXTENT;
    return (FfpScratchSettings){
        .fit = {.render = ffp_render_defaults(),
                .rates = {.rate = {[FFP_CENTRE] = 1.6e-4F * extent,
                                   [FFP_SCALE] = 0.005F,
                                   [FFP_ROTATION] = 0.001F,
                                   [FFP_OPACITY] = 0.05F,
                                   [FFP_ALBEDO] = 0.01F,
                                   [FFP_ROUGHNESS] = 0.01F,
                                   [FFP_AMBIENT] = 0.0025F}},
                .decay = 1,
                .centre_decay = 0.01,
                .centre_decay_steps = 30000,
                .beta1 = 0.9F,
                .beta2 = 0.999F,
                .epsilon = 1e-15F,
                .l1 = 0.8F,
                .ssim = 0.2F,
                .mask = 0.1F,
                .roughness_smooth = 0.002F,
                .distortion = 0.01F,
                .distortion_from = 3000,
                .one_picture = released,
                .measure = true,
                .seed = 1},
        .density = {.from = 500,
                    .until = 15000,
                    .every = 100,
                    .reset_every = 3000,
                    .reset_to = 0.01F,
                    .gradient = 2e-4F,
                    .small = 0.01F * extent,
                    .least_opacity = 0.05F,
                    .most = 400000},
        .cube = released,
        .points = released ? 100000 : 20000,
    };
}

// True if no view that has the point in its picture sees past it.
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
        for (int k = 0; k < 4; k++) {
            q[k] = (real)ffp_rng_normal(rng);
            square += q[k] * q[k];
        }
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
                        "Gaussians are fitted from scratch on the CPU only");
    if (count <= NEAREST)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, capture->folder, "%lld points are too few to start from",
                        (long long)count);
    return true;
}

bool ffp_scratch_gaussians(FfpGaussians *gaussians, const FfpCapture *capture,
                           const FfpScratchSettings *settings, FfpError *err) {
    FfpRng rng = ffp_rng(settings->fit.seed, settings->cube ? 4 : 3);
    const FfpGaussians *given = settings->given;
    const int64_t count = given ? given->count : settings->points;
    if (!check(capture, count, err)) return false;
    *gaussians = ffp_gaussians_new(count);
    if (given)
        memcpy(gaussians->centre, given->centre, 3 * (size_t)count * sizeof(real));
    else if (settings->cube)
        for (int64_t i = 0; i < 3 * gaussians->count; i++)
            gaussians->centre[i] = ffp_rng_range(&rng, -1.3F, 1.3F);
    else if (!draw_points(gaussians->centre, capture, gaussians->count, &rng)) {
        ffp_gaussians_free(gaussians);
        return ffp_fail(err, FFP_ERROR_ARGUMENT, capture->folder,
                        "the views' silhouettes leave no common room for an object");
    }
    place_splats(gaussians, &rng);
    return true;
}

// Before a whole scene the cameras stand nearer to each other than around an object.
static real scene_extent(const FfpCapture *capture) {
    real mean[3] = {0}, most = 0;
    for (int v = 0; v < capture->n_views; v++)
        for (int k = 0; k < 3; k++)
            mean[k] += capture->views[v].camera.pose[4 * k + 3] / (real)capture->n_views;
    for (int v = 0; v < capture->n_views; v++) {
        real square = 0;
        for (int k = 0; k < 3; k++) {
            const real away = capture->views[v].camera.pose[4 * k + 3] - mean[k];
            square += away * away;
        }
        most = fmax(most, sqrt(square));
    }
    return most > 0 ? 1.1F * most : OBJECT_EXTENT;
}

bool ffp_scratch_fit(FfpGaussians *gaussians, const FfpCapture *capture, const int *patterns, int n_patterns,
                     const FfpScratchSettings *settings, FfpRefineResult *result, FfpError *err) {
    if (!ffp_scratch_gaussians(gaussians, capture, settings, err)) return false;
    const real extent = capture->scene ? scene_extent(capture) / OBJECT_EXTENT : 1;
    FfpDensity density = settings->density;
    density.small *= extent;
    FfpDensityControl control = ffp_density_control_new(&density, gaussians->count, settings->fit.seed);
    const FfpGrowth growth = ffp_density_growth(&control);
    FfpRefineSettings fit = settings->fit;
    fit.rates.rate[FFP_CENTRE] *= extent;
    fit.growth = &growth;
    ffp_cancel_hold_off(true);
    const bool ok = ffp_refine_offered(gaussians, capture, patterns, n_patterns, &fit, result, err);
    ffp_density_control_free(&control);
    return ok;
}
