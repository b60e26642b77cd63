// The fine search at one pixel (engine/match/refine.h), one text for the CPU and the GPU.
#ifndef FFP_MATCH_FINE_FORMULA_H
#define FFP_MATCH_FINE_FORMULA_H

#include "engine/match/blurred.h"
#include "engine/match/refine.h"

#define FFP_FINE_WINDOW 2    // the cost is summed over 5 x 5 pixels, less the corners
#define FFP_FINE_PRIOR 0.02F // cost of lying a whole range off the plane, a unit of weight
#define FFP_FINE_OFF_PATTERN                                                                                 \
    0.5F // cost of a hypothesis that leaves the pattern, a unit of weight and a pattern

// Hypotheses `from` up to, not including, `end`, numbered from 0 at -range.
typedef struct FfpFineSpan {
    int from, end;
    real step; // between two of them
} FfpFineSpan;

// Adds the costs of the neighbour at (x + dx, y + dy) along the plane, `outside` for hypotheses off the
// pattern; both begin at the span's first. Returns its weight.
FFP_FORMULA real ffp_fine_neighbour(FfpCell *cost, real *outside, const FfpFineSearch *search,
                                    const FfpPlane *plane, int x, int y, int dx, int dy, FfpFineSpan span) {
    // Weight of a neighbour by its squared distance: exp(-0.35 d^2).
    static const real nearness[FFP_FINE_WINDOW * FFP_FINE_WINDOW + 2] = {1,       0.7047F, 0.4966F,
                                                                         0.3499F, 0.2466F, 0.1738F};
    const FfpObservation *observed = search->observed;
    const FfpBlurred *patterns = search->patterns;
    const size_t i = (size_t)(y + dy) * (size_t)observed->width + (size_t)(x + dx);
    const real near = nearness[dx * dx + dy * dy],
               off = near * (FFP_FINE_OFF_PATTERN * (real)observed->count);
    const FfpLine line =
        ffp_line(search->camera, (real)(x + dx) + 0.5F, (real)(y + dy) + 0.5F, search->projector);
    // The line in inverse depth: both its numbers divided by depth.
    const FfpLine inverse = {{line.u[1], line.u[0]}, {line.v[1], line.v[0]}, {line.w[1], line.w[0]}};
    const real base = plane->q0 + plane->qx * (real)dx + plane->qy * (real)dy;
    for (int k = span.from; k < span.end; k += FFP_MATCH_LANES) {
        real u[FFP_MATCH_LANES], v[FFP_MATCH_LANES];
        FfpCellPlaces cells;
        FfpCell *here_cost = cost + (k - span.from);
        ffp_line_positions(&inverse, base, span.step, k - search->steps / 2, u, v);
        ffp_find_cells(&cells, patterns, u, v);
        const int lanes = span.end - k < FFP_MATCH_LANES ? span.end - k : FFP_MATCH_LANES;
        for (int p = 0; p < observed->count; p++) {
            FfpObservedPixel here = ffp_observed_pixel(observed, patterns, p, i);
            here.weight = near * here.weight;
            for (int n = 0; n < lanes; n++)
                if (cells.first[n] >= 0)
                    here_cost[n] = here_cost[n] + ffp_blurred_cost(&here, patterns->stride, &cells, n);
        }
        for (int n = 0; n < lanes; n++)
            if (cells.first[n] < 0) outside[k - span.from + n] += off;
    }
    return near * observed->lit[i];
}

// Costs of the span's hypotheses at the pixel's plane; channels is working memory, both are
// [end - from] and zero.
FFP_FORMULA void ffp_fine_costs(real *cost, FfpCell *channels, const FfpFineSearch *search,
                                const FfpPlane *plane, int x, int y, FfpFineSpan span) {
    const FfpObservation *observed = search->observed;
    real total = 0;
    for (int dy = -FFP_FINE_WINDOW; dy <= FFP_FINE_WINDOW; dy++) {
        for (int dx = -FFP_FINE_WINDOW; dx <= FFP_FINE_WINDOW; dx++) {
            if (dx * dx + dy * dy > FFP_FINE_WINDOW * FFP_FINE_WINDOW + 1) continue;
            if (x + dx < 0 || x + dx >= observed->width || y + dy < 0 || y + dy >= observed->height) continue;
            if (observed->lit[(size_t)(y + dy) * (size_t)observed->width + (size_t)(x + dx)] <= 0) continue;
            total += ffp_fine_neighbour(channels, cost, search, plane, x, y, dx, dy, span);
        }
    }
    const real middle = (real)(search->steps / 2);
    for (int k = span.from; k < span.end; k++) {
        const real off = ((real)k - middle) / middle;
        cost[k - span.from] += ffp_sum_channels(channels[k - span.from]) + FFP_FINE_PRIOR * total * off * off;
    }
}

// Index of the least cost with the parabola through it and its neighbours.
FFP_FORMULA real ffp_fine_least(const real *cost, int steps) {
    int best = 0;
    for (int k = 1; k < steps; k++)
        if (cost[k] < cost[best]) best = k;
    if (best == 0 || best == steps - 1) return (real)best;
    const real a = cost[best - 1], b = cost[best], c = cost[best + 1], bend = a - 2 * b + c;
    return (real)best + (bend > 0 ? 0.5F * (a - c) / bend : 0);
}

#endif
