#include "match/sweep.h"

#include <tgmath.h>

#include "match/blurred.h"
#include "match/line.h"

#define OUTSIDE_COST                                                                                         \
    1.0F // of a hypothesis off the pattern or off a silhouette: as much as a clearly wrong colour

FfpPlanes ffp_planes(const FfpCapture *capture, int view, const FfpMatchSettings *settings) {
    const FfpCamera *camera = &capture->views[view].camera;
    real x, y;
    const real z = ffp_project(camera, capture->centre, &x, &y), reach = settings->bounds * capture->radius;
    const real first = fmax(z - reach, 0.02F * reach), last = fmax(z + reach, 2 * first);
    return (FfpPlanes){settings->coarse_steps, first, (last - first) / (real)(settings->coarse_steps - 1)};
}

// Is any coverage within a pixel of (u, v)? What lies outside the image is not known to be empty.
static bool inside_silhouette(const FfpImage *coverage, real u, real v) {
    const int x = (int)floor(u), y = (int)floor(v);
    if (x < 1 || y < 1 || x >= coverage->width - 1 || y >= coverage->height - 1) return true;
    const real *row = coverage->data + (size_t)(y - 1) * (size_t)coverage->width + (size_t)x - 1;
    real most = 0;
    for (int j = 0; j < 3; j++, row += coverage->width) most = fmax(most, fmax(row[0], fmax(row[1], row[2])));
    return most > 0;
}

static void add_hull(real *cost, const FfpCapture *capture, int view, real x, real y,
                     const FfpPlanes *planes) {
    for (int other = 0; other < capture->n_views; other++) {
        if (other == view) continue;
        const FfpView *seer = &capture->views[other];
        const FfpLine line = ffp_line(&capture->views[view].camera, x, y, &seer->camera);
        for (int k = 0; k < planes->count; k++) {
            real u = 0, v = 0;
            const real w = ffp_line_at(&line, planes->first + (real)k * planes->step, &u, &v);
            if (w > 0 && !inside_silhouette(&seer->coverage, u, v)) cost[k] = OUTSIDE_COST;
        }
    }
}

static void add_colour(real *cost, const FfpBlurred *pattern, const FfpLine *line, const real ratio[3],
                       const real weight[3], const FfpPlanes *planes) {
    const real total = weight[0] + weight[1] + weight[2];
    for (int k = 0; k < planes->count; k++) {
        real u = -1, v = -1, rgb[3];
        ffp_line_at(line, planes->first + (real)k * planes->step, &u, &v);
        if (u < 0 || v < 0 || u > pattern->width || v > pattern->height) {
            cost[k] = OUTSIDE_COST * total;
            continue;
        }
        ffp_blurred_sample(pattern, u, v, rgb);
        real sum = 0;
        for (int c = 0; c < 3; c++) sum += weight[c] * (ratio[c] - rgb[c]) * (ratio[c] - rgb[c]);
        cost[k] = sum;
    }
}

void ffp_sweep(real *cost, const FfpCapture *capture, int view, const FfpObservation *seen,
               const FfpBlurred *pattern, const FfpPlanes *planes, bool hull) {
    const FfpView *self = &capture->views[view];
    for (int y = 0; y < seen->height; y++) {
        for (int x = 0; x < seen->width; x++) {
            const size_t i = (size_t)y * (size_t)seen->width + (size_t)x;
            if (self->coverage.data[i] <= 0) continue;
            real *row = cost + i * (size_t)planes->count;
            const FfpLine line = ffp_line(&self->camera, (real)x + 0.5F, (real)y + 0.5F, &self->projector);
            add_colour(row, pattern, &line, seen->ratio + 3 * i, seen->weight + 3 * i, planes);
            if (hull) add_hull(row, capture, view, (real)x + 0.5F, (real)y + 0.5F, planes);
        }
    }
}
