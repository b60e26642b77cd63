#include "engine/match/matching.h"
#include <string.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "core/base/call.h"
#include "engine/match/coded.h"
#include "engine/match/line.h"
#include "engine/match/refine.h"
#include "engine/match/sweep.h"
#include "engine/match/thresholds.h"

real ffp_window_costs(real *restrict sum, const real *cost, const FfpForeground *foreground,
                      const FfpObservation *observed, int x, int y, int count) {
    real weight = 0;
    memset(sum, 0, (size_t)count * sizeof(real));
    for (int j = y > 0 ? y - 1 : y; j <= y + 1 && j < observed->height; j++) {
        for (int i = x > 0 ? x - 1 : x; i <= x + 1 && i < observed->width; i++) {
            const size_t pixel = (size_t)j * (size_t)observed->width + (size_t)i,
                         slot = foreground->slot[pixel];
            if (slot == FFP_OFF) continue;
            const real *restrict row = cost + slot * (size_t)count;
            for (int k = 0; k < count; k++) sum[k] += row[k];
            weight += (real)(3 * observed->count) * observed->lit[pixel];
        }
    }
    return weight;
}

real ffp_rival_cost(const real *sum, int count, int chosen) {
    real least = FFP_FAR_COST, greatest = 0;
#pragma omp simd reduction(min : least) reduction(max : greatest)
    for (int k = 0; k < count; k++) {
        const bool minimum = (sum[k - 1] >= sum[k]) & (sum[k + 1] >= sum[k]),
                   apart = (k <= chosen - FFP_RIVAL_APART) | (k >= chosen + FFP_RIVAL_APART);
        const real value = (minimum & apart) ? sum[k] : FFP_FAR_COST;
        least = value < least ? value : least;
        greatest = sum[k] > greatest ? sum[k] : greatest;
    }
    return least < FFP_FAR_COST ? least : greatest;
}

int ffp_least_cost(const real *values, int count) {
    real least = values[0];
#pragma omp simd reduction(min : least)
    for (int k = 1; k < count; k++) least = values[k] < least ? values[k] : least;
    int best = 0;
    while (best + 1 < count && values[best] != least) best++;
    return best;
}

// Reads depth and confidence off the aggregated costs of a view.
static void choose(real *depth, real *confidence, const real *total, const real *cost,
                   const FfpForeground *foreground, const FfpObservation *observed, const FfpPlanes *planes) {
    const int count = planes->count;
    real *row = ffp_alloc((size_t)count + 2, sizeof(real)), *sum = row + 1;
    row[0] = row[count + 1] = FFP_FAR_COST;
    for (size_t slot = 0; slot < foreground->count; slot++) {
        const size_t i = foreground->pixel[slot];
        const int x = (int)(i % (size_t)observed->width), y = (int)(i / (size_t)observed->width);
        const int best = ffp_least_cost(total + slot * (size_t)count, count);
        depth[i] = ffp_plane_depth(planes, (real)best);
        if (observed->lit[i] < FFP_LIT_MIN) continue;
        const real weight = ffp_window_costs(sum, cost, foreground, observed, x, y, count);
        if (sum[best] > FFP_FITTING_COST * weight) continue;
        const real second = ffp_rival_cost(sum, count, best);
        confidence[i] = second > 0 ? fmax(1 - sum[best] / second, 0) * observed->lit[i] : 0;
    }
    ffp_free(row);
}

size_t ffp_match_bytes(const FfpCamera *camera, const FfpMatchSettings *settings) {
    const size_t cells = (size_t)camera->width * (size_t)camera->height * (size_t)settings->coarse_steps;
    return cells * (2 * sizeof(real) + 1); // costs, their totals, the hull
}

// The plane of least cost and its confidence, of every pixel on the object.
static void search(real *depth, real *confidence, real *range, unsigned char **hull,
                   const FfpCapture *capture, int view, const FfpObservation *observed,
                   const FfpBlurred *patterns, const FfpPlanes *planes) {
    const FfpView *self = &capture->views[view];
    FfpForeground foreground = ffp_foreground_new(&self->coverage);
    const size_t cells = foreground.count * (size_t)planes->count;
    real *cost = ffp_alloc(cells, sizeof(real)), *total = ffp_alloc(cells, sizeof(real));
    unsigned char *inside = ffp_alloc(cells, 1);
    ffp_hull(inside, capture, view, &foreground, planes);
    if (range) ffp_hull_range(range, inside, &foreground, planes);
    ffp_cancel_point();
    ffp_sweep(cost, self, &foreground, observed, patterns, planes, inside);
    ffp_coded_costs(cost, capture, view, &foreground, planes);
    ffp_cancel_point();
    ffp_semi_global(total, cost, &foreground, planes->count,
                    &(FfpSteps){.small = FFP_SMALL_STEP, .large = FFP_LARGE_STEP});
    choose(depth, confidence, total, cost, &foreground, observed, planes);
    ffp_free(total);
    ffp_free(cost);
    if (hull)
        *hull = inside;
    else
        ffp_free(inside);
    ffp_foreground_free(&foreground);
}

void ffp_match_view(real *depth, real *confidence, real *range, unsigned char **hull,
                    const FfpCapture *capture, int view, const FfpObservation *observed,
                    const FfpBlurred *patterns, const FfpMatchSettings *settings) {
    const FfpPlanes planes = ffp_planes(capture, view, settings);
    const size_t pixels = (size_t)observed->width * (size_t)observed->height;
    memset(depth, 0, pixels * sizeof(real));
    memset(confidence, 0, pixels * sizeof(real));
    search(depth, confidence, range, hull, capture, view, observed, patterns, &planes);
    ffp_coded_depths(depth, confidence, capture, view, settings->bounds);
    const int steps =
        settings->fine_steps < FFP_REFINE_STEPS_MAX ? settings->fine_steps : FFP_REFINE_STEPS_MAX;
    const FfpFineSearch fine = {
        &capture->views[view].camera, &capture->views[view].projector, observed, patterns, steps, false};
    real *finer = ffp_alloc(pixels, sizeof(real)), span = 2 * planes.step;
    for (int round = 0; round < FFP_SEARCH_ROUNDS; round++) {
        ffp_cancel_point();
        ffp_refine_depth(finer, depth, confidence, &fine, span);
        memcpy(depth, finer, pixels * sizeof(real));
        span /= 2;
    }
    ffp_coded_depths(depth, confidence, capture, view, settings->bounds);
    ffp_free(finer);
}
