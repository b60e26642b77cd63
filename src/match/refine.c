#include "match/refine.h"

#include <tgmath.h>

#include "match/blurred.h"
#include "match/line.h"

#define WINDOW 2 // the cost is summed over 5 x 5 pixels
#define STEPS_MAX 256
#define PRIOR 0.02F      // cost of lying a whole range off the plane, a unit of weight
#define OFF_PATTERN 0.5F // cost of a hypothesis that leaves the pattern, a unit of weight

// Adds a neighbour's costs along the plane for all hypotheses. Returns its weight.
static real add_neighbour(real *cost, const FfpView *view, const FfpObservation *seen,
                          const FfpBlurred *pattern, const FfpPlane *plane, int x, int y, int dx, int dy,
                          int steps, real step) {
    const size_t i = (size_t)(y + dy) * (size_t)seen->width + (size_t)(x + dx);
    const real near = exp(-0.35F * (real)(dx * dx + dy * dy));
    const real *ratio = seen->ratio + 3 * i, *weight = seen->weight + 3 * i;
    const FfpLine line =
        ffp_line(&view->camera, (real)(x + dx) + 0.5F, (real)(y + dy) + 0.5F, &view->projector);
    const real base = plane->q0 + plane->qx * dx + plane->qy * dy;
    for (int k = 0; k < steps; k++) {
        real u = -1, v = -1, rgb[3];
        const real q = base + (real)(k - steps / 2) * step;
        if (q > 0) ffp_line_at(&line, 1 / q, &u, &v);
        if (u < 0 || v < 0 || u > pattern->width || v > pattern->height) {
            cost[k] += near * OFF_PATTERN;
            continue;
        }
        ffp_blurred_sample(pattern, u, v, rgb);
        real sum = 0;
        for (int c = 0; c < 3; c++) sum += weight[c] * (ratio[c] - rgb[c]) * (ratio[c] - rgb[c]);
        cost[k] += near * sum;
    }
    return near * seen->lit[i];
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

static real refine_pixel(const FfpView *view, const FfpObservation *seen, const FfpBlurred *pattern,
                         const FfpPlane *plane, int x, int y, int steps, real step) {
    real cost[STEPS_MAX] = {0}, total = 0;
    for (int dy = -WINDOW; dy <= WINDOW; dy++) {
        for (int dx = -WINDOW; dx <= WINDOW; dx++) {
            if (x + dx < 0 || x + dx >= seen->width || y + dy < 0 || y + dy >= seen->height) continue;
            if (seen->lit[(size_t)(y + dy) * (size_t)seen->width + (size_t)(x + dx)] <= 0) continue;
            total += add_neighbour(cost, view, seen, pattern, plane, x, y, dx, dy, steps, step);
        }
    }
    const real middle = (real)(steps / 2);
    for (int k = 0; k < steps; k++) {
        const real off = ((real)k - middle) / middle;
        cost[k] += PRIOR * total * off * off;
    }
    return plane->q0 + (least_at(cost, steps) - middle) * step;
}

void ffp_refine(real *out, const real *depth, const real *weight, const FfpView *view,
                const FfpObservation *seen, const FfpBlurred *pattern, int steps, real range) {
    if (steps > STEPS_MAX) steps = STEPS_MAX;
    for (int y = 0; y < seen->height; y++) {
        for (int x = 0; x < seen->width; x++) {
            const size_t i = (size_t)y * (size_t)seen->width + (size_t)x;
            FfpPlane plane;
            out[i] = depth[i];
            if (weight[i] <= 0 || !ffp_fit_plane(&plane, depth, weight, &view->camera, x, y, 2)) continue;
            const real step = range * plane.q0 * plane.q0 / (real)(steps / 2);
            const real q = refine_pixel(view, seen, pattern, &plane, x, y, steps, step);
            if (q > 0) out[i] = 1 / q;
        }
    }
}
