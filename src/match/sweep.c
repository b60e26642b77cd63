#include "match/sweep.h"

#include <string.h>
#include <tgmath.h>

#include "match/blurred.h"
#include "match/kernels/kernels.h"
#include "match/line.h"

#define OUTSIDE_COST 1.0F // a channel, off the pattern or off a silhouette: as much as a clearly wrong colour

FfpPlanes ffp_planes(const FfpCapture *capture, int view, const FfpMatchSettings *settings) {
    const FfpCamera *camera = &capture->views[view].camera;
    real x, y;
    const real z = ffp_project(camera, capture->centre, &x, &y), reach = settings->bounds * capture->radius;
    const real first = fmax(z - reach, 0.02F * reach), last = fmax(z + reach, 2 * first);
    return (FfpPlanes){settings->coarse_steps, first, (last - first) / (real)(settings->coarse_steps - 1)};
}

// Costs of a pixel's hypotheses that are inside the hull.
static void add_colour(real *cost, const FfpBlurred *pattern, const FfpLine *line, const FfpSeen *seen,
                       const FfpPlanes *planes, const unsigned char *inside) {
    const real outside = OUTSIDE_COST * ffp_sum_channels(seen->weight);
    for (int k = 0; k < planes->count; k += FFP_MATCH_LANES) {
        const int lanes = planes->count - k < FFP_MATCH_LANES ? planes->count - k : FFP_MATCH_LANES;
        if (memchr(inside + k, 1, (size_t)lanes) == NULL) continue;
        real u[FFP_MATCH_LANES], v[FFP_MATCH_LANES];
        FfpCells cells;
        ffp_line_positions(line, planes->first, planes->step, k, u, v);
        ffp_find_cells(&cells, pattern, u, v);
        for (int n = 0; n < lanes; n++) {
            if (!inside[k + n]) continue;
            cost[k + n] =
                cells.first[n] >= 0 ? ffp_sum_channels(ffp_blurred_cost(pattern, &cells, n, seen)) : outside;
        }
    }
}

void ffp_sweep(real *cost, const FfpView *view, const FfpForeground *foreground, const FfpObservation *seen,
               const FfpBlurred *pattern, const FfpPlanes *planes, const unsigned char *inside) {
    const size_t count = (size_t)planes->count, width = (size_t)foreground->width;
    for (size_t slot = 0; slot < foreground->count; slot++) {
        const size_t i = foreground->pixel[slot], first = slot * count;
        const real x = (real)(i % width) + 0.5F, y = (real)(i / width) + 0.5F;
        const FfpLine line = ffp_line(&view->camera, x, y, &view->projector);
        const FfpSeen here = ffp_seen(seen, i);
        for (size_t k = 0; k < count; k++) cost[first + k] = OUTSIDE_COST;
        add_colour(cost + first, pattern, &line, &here, planes, inside + first);
    }
}

void ffp_semi_global(real *total, const real *cost, const FfpForeground *foreground, int count, real small,
                     real large) {
    ffp_match_kernels()->semi_global(total, cost, foreground, count, small, large);
}
