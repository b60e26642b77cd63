#include "engine/match/sweep.h"
#include <string.h>
#include <tgmath.h>
#include "core/base/alloc.h"
#include "engine/match/blurred.h"
#include "engine/match/kernels/kernels.h"
#include "engine/match/line.h"
#include "engine/match/matching.h"

#define SCENE_STEPS 192 // hypotheses between the near and the far end of a scene

FfpMatchSettings ffp_match_defaults(void) {
    return (FfpMatchSettings){128, 16, 1.05F, NULL};
}

FfpPlanes ffp_planes(const FfpCapture *capture, int view, const FfpMatchSettings *settings) {
    const FfpCamera *camera = &capture->views[view].camera;
    real x, y;
    if (capture->scene) {
        const real first = 1 / capture->views[view].far, last = 1 / capture->views[view].near;
        return (FfpPlanes){SCENE_STEPS, true, first, (last - first) / (SCENE_STEPS - 1)};
    }
    const real z = ffp_project(camera, capture->centre, &x, &y), reach = settings->bounds * capture->radius;
    const real first = fmax(z - reach, 0.02F * reach), last = fmax(z + reach, 2 * first);
    return (FfpPlanes){settings->coarse_steps, false, first,
                       (last - first) / (real)(settings->coarse_steps - 1)};
}

// A pixel's values under all of its patterns.
typedef struct Pixel {
    const FfpObservedPixel *observed; // [count]
    int count;
    real outside; // cost of a hypothesis off the pattern
} Pixel;

// Sum over the patterns at position n of the cells.
static real cost_at(const Pixel *pixel, int stride, const FfpCellPlaces *cells, int n) {
    FfpCell sum = {0};
    for (int k = 0; k < pixel->count; k++) sum += ffp_blurred_cost(&pixel->observed[k], stride, cells, n);
    return ffp_sum_channels(sum);
}

// Costs of a pixel's hypotheses that are inside the hull.
static void add_colour(real *cost, const FfpBlurred *patterns, const FfpLine *line, const Pixel *pixel,
                       const FfpPlanes *planes, const unsigned char *inside) {
    for (int k = 0; k < planes->count; k += FFP_MATCH_LANES) {
        const int lanes = planes->count - k < FFP_MATCH_LANES ? planes->count - k : FFP_MATCH_LANES;
        if (memchr(inside + k, 1, (size_t)lanes) == NULL) continue;
        real u[FFP_MATCH_LANES], v[FFP_MATCH_LANES];
        FfpCellPlaces cells;
        ffp_line_positions(line, planes->first, planes->step, k, u, v);
        ffp_find_cells(&cells, patterns, u, v);
        for (int n = 0; n < lanes; n++) {
            if (!inside[k + n]) continue;
            cost[k + n] = cells.first[n] >= 0 ? cost_at(pixel, patterns->stride, &cells, n) : pixel->outside;
        }
    }
}

void ffp_sweep(real *cost, const FfpView *view, const FfpForeground *foreground,
               const FfpObservation *observed, const FfpBlurred *patterns, const FfpPlanes *planes,
               const unsigned char *inside) {
    const size_t count = (size_t)planes->count, width = (size_t)foreground->width;
    const real outside = FFP_OUTSIDE_COST * (real)observed->count;
    FfpObservedPixel *here = ffp_alloc((size_t)observed->count, sizeof *here);
    for (size_t slot = 0; slot < foreground->count; slot++) {
        const size_t i = foreground->pixel[slot], first = slot * count;
        const real x = (real)(i % width) + 0.5F, y = (real)(i / width) + 0.5F;
        const FfpLine line = ffp_plane_line(planes, ffp_line(&view->camera, x, y, &view->projector));
        for (int k = 0; k < observed->count; k++) here[k] = ffp_observed_pixel(observed, patterns, k, i);
        const real *w = observed->weight + 3 * i;
        const Pixel pixel = {here, observed->count, outside * ((w[0] + w[1]) + w[2])};
        for (size_t k = 0; k < count; k++) cost[first + k] = outside;
        add_colour(cost + first, patterns, &line, &pixel, planes, inside + first);
    }
    ffp_free(here);
}

void ffp_semi_global(real *total, const real *cost, const FfpForeground *foreground, int count,
                     const FfpSteps *steps) {
    ffp_match_kernels()->semi_global(total, cost, foreground, count, steps);
}
