#include "match/sweep.h"

#include <tgmath.h>

#include "match/blurred.h"
#include "match/line.h"

#define OUTSIDE_COST 1.0F // a channel, off the pattern or off a silhouette: as much as a clearly wrong colour

FfpPlanes ffp_planes(const FfpCapture *capture, int view, const FfpMatchSettings *settings) {
    const FfpCamera *camera = &capture->views[view].camera;
    real x, y;
    const real z = ffp_project(camera, capture->centre, &x, &y), reach = settings->bounds * capture->radius;
    const real first = fmax(z - reach, 0.02F * reach), last = fmax(z + reach, 2 * first);
    return (FfpPlanes){settings->coarse_steps, first, (last - first) / (real)(settings->coarse_steps - 1)};
}

static void add_colour(real *cost, const FfpBlurred *pattern, const FfpLine *line, const FfpSeen *seen,
                       const FfpPlanes *planes) {
    const real outside = OUTSIDE_COST * (seen->weight[0] + seen->weight[1] + seen->weight[2]);
    for (int k = 0; k < planes->count; k++) {
        real u = -1, v = -1;
        ffp_line_at(line, planes->first + (real)k * planes->step, &u, &v);
        cost[k] = ffp_blurred_cost(pattern, u, v, seen, outside);
    }
}

void ffp_sweep(real *cost, const FfpView *view, const FfpObservation *seen, const FfpBlurred *pattern,
               const FfpPlanes *planes, const unsigned char *inside) {
    for (int y = 0; y < seen->height; y++) {
        for (int x = 0; x < seen->width; x++) {
            const size_t i = (size_t)y * (size_t)seen->width + (size_t)x, first = i * (size_t)planes->count;
            if (view->coverage.data[i] <= 0) continue;
            const FfpLine line = ffp_line(&view->camera, (real)x + 0.5F, (real)y + 0.5F, &view->projector);
            const FfpSeen here = ffp_seen(seen, i);
            add_colour(cost + first, pattern, &line, &here, planes);
            for (int k = 0; k < planes->count; k++)
                if (!inside[first + (size_t)k]) cost[first + (size_t)k] = OUTSIDE_COST;
        }
    }
}
