// The fine search at one pixel (engine/match/refine.h).
#include <tgmath.h>
#include "engine/match/kernels/kernels.h"

#define WINDOW 2         // the cost is summed over 5 x 5 pixels, less the corners
#define PRIOR 0.02F      // cost of lying a whole range off the plane, a unit of weight
#define OFF_PATTERN 0.5F // cost of a hypothesis that leaves the pattern, a unit of weight and a pattern

// Weight of a neighbour by its squared distance: exp(-0.35 d^2).
static const real nearness[WINDOW * WINDOW + 2] = {1, 0.7047F, 0.4966F, 0.3499F, 0.2466F, 0.1738F};

// Adds the costs of the neighbour at (x + dx, y + dy) along the plane for all hypotheses, `outside` for those
// off the pattern. Returns its weight.
static real add_neighbour(FfpCell *cost, real *outside, const FfpFineSearch *search, const FfpPlane *plane,
                          int x, int y, int dx, int dy, real step) {
    const FfpView *view = search->view;
    const FfpObservation *observed = search->observed;
    const FfpBlurred *patterns = search->patterns;
    const int steps = search->steps;
    const size_t i = (size_t)(y + dy) * (size_t)observed->width + (size_t)(x + dx);
    const real near = nearness[dx * dx + dy * dy], off = near * (OFF_PATTERN * (real)observed->count);
    const FfpLine line =
        ffp_line(&view->camera, (real)(x + dx) + 0.5F, (real)(y + dy) + 0.5F, &view->projector);
    // The line in inverse depth: both its numbers divided by depth.
    const FfpLine inverse = {{line.u[1], line.u[0]}, {line.v[1], line.v[0]}, {line.w[1], line.w[0]}};
    const real base = plane->q0 + plane->qx * (real)dx + plane->qy * (real)dy;
    for (int k = 0; k < steps; k += FFP_MATCH_LANES) {
        real u[FFP_MATCH_LANES], v[FFP_MATCH_LANES];
        FfpCellPlaces cells;
        ffp_line_positions(&inverse, base, step, k - steps / 2, u, v);
        ffp_find_cells(&cells, patterns, u, v);
        const int lanes = steps - k < FFP_MATCH_LANES ? steps - k : FFP_MATCH_LANES;
        for (int p = 0; p < observed->count; p++) {
            FfpObservedPixel here = ffp_observed_pixel(observed, patterns, p, i);
            here.weight *= near;
            for (int n = 0; n < lanes; n++)
                if (cells.first[n] >= 0) cost[k + n] += ffp_blurred_cost(&here, patterns->stride, &cells, n);
        }
        for (int n = 0; n < lanes; n++)
            if (cells.first[n] < 0) outside[k + n] += off;
    }
    return near * observed->lit[i];
}

// Index of the least cost with the parabola through it and its neighbours.
static real least_at(const real *cost, int steps) {
    int best = 0;
    for (int k = 1; k < steps; k++)
        if (cost[k] < cost[best]) best = k;
    if (best == 0 || best == steps - 1) return (real)best;
    const real a = cost[best - 1], b = cost[best], c = cost[best + 1], bend = a - 2 * b + c;
    return (real)best + (bend > 0 ? 0.5F * (a - c) / bend : 0);
}

real FFP_K(refine_pixel)(const FfpFineSearch *search, const FfpPlane *plane, int x, int y, real step) {
    const FfpObservation *observed = search->observed;
    const int steps = search->steps;
    FfpCell channels[FFP_REFINE_STEPS_MAX];
    real cost[FFP_REFINE_STEPS_MAX], total = 0;
    for (int k = 0; k < steps; k++) {
        channels[k] = (FfpCell){0};
        cost[k] = 0;
    }
    for (int dy = -WINDOW; dy <= WINDOW; dy++) {
        for (int dx = -WINDOW; dx <= WINDOW; dx++) {
            if (dx * dx + dy * dy > WINDOW * WINDOW + 1) continue;
            if (x + dx < 0 || x + dx >= observed->width || y + dy < 0 || y + dy >= observed->height) continue;
            if (observed->lit[(size_t)(y + dy) * (size_t)observed->width + (size_t)(x + dx)] <= 0) continue;
            total += add_neighbour(channels, cost, search, plane, x, y, dx, dy, step);
        }
    }
    const int half = steps / 2;
    const real middle = (real)half;
    for (int k = 0; k < steps; k++) {
        const real off = ((real)k - middle) / middle;
        cost[k] += ffp_sum_channels(channels[k]) + PRIOR * total * off * off;
    }
    return plane->q0 + (least_at(cost, steps) - middle) * step;
}
