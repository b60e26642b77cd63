#include "engine/match/enlarge.h"
#include <stdlib.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "engine/match/blurred.h"
#include "engine/match/surface.h"
#include "engine/match/thresholds.h"

#define PLANE_REACH 2    // reduced pixels that a local plane is fitted to
#define APART 3.0F       // footprints of a reduced pixel between planes that are of different surfaces
#define CLEARLY 0.5F     // of the cost under a pixel's own surface, below which another is believed
#define OFF_PATTERN 1.0F // cost of a depth that leaves the pattern
#define AROUND 9

// The reduced pixels around a position, and what their planes say of it.
typedef struct Near {
    real q[AROUND], weight[AROUND]; // inverse depth there, 0: no surface; share in the blend
    const FfpPlane *plane[AROUND];
    real apart; // of inverse depths that are of different surfaces
} Near;

typedef struct Work {
    const FfpReduced *reduced;
    const FfpView *full;
    const FfpObservation *observed;
    const FfpBlurred *patterns;
    FfpPlane *planes; // [h,w] of the reduced view
    int width, height;
    real across, down; // its pixels for one at full size
} Work;

static FfpPlane *fit_planes(const FfpReduced *reduced, int view) {
    const FfpInitialisation *start = &reduced->start;
    const FfpCamera *camera = &reduced->capture.views[view].camera;
    const size_t area = (size_t)start->width * (size_t)start->height, first = (size_t)view * area;
    real *depth = ffp_alloc(area, sizeof(real));
    for (size_t i = 0; i < area; i++) depth[i] = start->footprint[first + i] * camera->fx;
    FfpSheet sheet = ffp_sheet_new(depth, depth, camera, PLANE_REACH);
    FfpPlane *out = ffp_alloc(area, sizeof *out);
    for (int y = 0; y < start->height; y++)
        for (int x = 0; x < start->width; x += FFP_MATCH_LANES) {
            FfpPlane planes[FFP_MATCH_LANES];
            ffp_fit_planes(planes, &sheet, x, y);
            for (int n = 0; n < FFP_MATCH_LANES && x + n < start->width; n++)
                out[(size_t)y * (size_t)start->width + (size_t)(x + n)] = planes[n];
        }
    ffp_sheet_free(&sheet);
    ffp_free(depth);
    return out;
}

// Shares of the previous, this and the next cell, for a position at t cells from this cell's centre.
static void spline(real share[3], real t) {
    share[0] = (0.5F - t) * (0.5F - t) / 2;
    share[1] = 0.75F - t * t;
    share[2] = (0.5F + t) * (0.5F + t) / 2;
}

// (u, v): position on the reduced picture, of a pixel whose cell has depth.
static Near look_around(const Work *w, real u, real v) {
    const int x = (int)u, y = (int)v;
    real across[3], down[3];
    Near near = {.apart = 0};
    spline(across, u - (real)x - 0.5F);
    spline(down, v - (real)y - 0.5F);
    for (int n = 0; n < AROUND; n++) {
        const int i = x + n % 3 - 1, j = y + n / 3 - 1;
        if (i < 0 || j < 0 || i >= w->width || j >= w->height) continue;
        const FfpPlane *plane = &w->planes[(size_t)j * (size_t)w->width + (size_t)i];
        if (plane->q0 <= 0) continue;
        const real q = plane->q0 + plane->qx * (u - (real)i - 0.5F) + plane->qy * (v - (real)j - 0.5F);
        near.plane[n] = plane;
        near.q[n] = fmax(q, 0.1F * plane->q0);
        near.weight[n] = across[n % 3] * down[n / 3];
    }
    return near;
}

// The blend of the planes on the surface of neighbour n, relative to the position. Where none of them has a
// share (the splines of a neighbour may end exactly here): the plane of n.
static FfpPlane blend(const Near *near, int n) {
    FfpPlane out = {0, 0, 0};
    real total = 0;
    for (int m = 0; m < AROUND; m++) {
        if (near->q[m] <= 0 || fabs(near->q[m] - near->q[n]) > near->apart) continue;
        const real share = near->weight[m];
        out.q0 += share * near->q[m];
        out.qx += share * near->plane[m]->qx;
        out.qy += share * near->plane[m]->qy;
        total += share;
    }
    if (!(total > 0)) return (FfpPlane){near->q[n], near->plane[n]->qx, near->plane[n]->qy};
    return (FfpPlane){out.q0 / total, out.qx / total, out.qy / total};
}

// Mean squared difference to the patterns of a pixel at inverse depth q, a unit of weight.
static real cost_at(const Work *w, int x, int y, real q) {
    const size_t i = (size_t)y * (size_t)w->observed->width + (size_t)x;
    const FfpLine line = ffp_line(&w->full->camera, (real)x + 0.5F, (real)y + 0.5F, &w->full->projector);
    FfpCell cost = {0}, weight = {0};
    real u[FFP_MATCH_LANES], v[FFP_MATCH_LANES];
    FfpCellPlaces cells;
    ffp_line_positions(&line, 1 / q, 0, 0, u, v);
    ffp_find_cells(&cells, w->patterns, u, v);
    if (cells.first[0] < 0) return OFF_PATTERN;
    for (int k = 0; k < w->observed->count; k++) {
        const FfpObservedPixel here = ffp_observed_pixel(w->observed, w->patterns, k, i);
        cost += ffp_blurred_cost(&here, w->patterns->stride, &cells, 0);
        weight += here.weight;
    }
    return ffp_sum_channels(cost) / ffp_sum_channels(weight);
}

// Which of the neighbours' surfaces pixel (x, y) shows.
static int choose_surface(const Work *w, const Near *near, int x, int y) {
    const int own = AROUND / 2;
    int best = own;
    real least = -1;
    if (w->observed->lit[(size_t)y * (size_t)w->observed->width + (size_t)x] < FFP_LIT_MIN) return own;
    for (int n = 0; n < AROUND; n++) {
        if (near->q[n] <= 0 || fabs(near->q[n] - near->q[best]) <= near->apart) continue;
        if (least < 0) least = CLEARLY * cost_at(w, x, y, near->q[own]);
        const real cost = cost_at(w, x, y, near->q[n]);
        if (cost < least) {
            best = n;
            least = cost;
        }
    }
    return best;
}

static void enlarge_pixel(const FfpEnlarged *out, const Work *w, int view, int x, int y) {
    const size_t i = (size_t)y * (size_t)w->observed->width + (size_t)x;
    const FfpInitialisation *start = &w->reduced->start;
    const real u = ((real)x + 0.5F) * w->across, v = ((real)y + 0.5F) * w->down;
    Near near = look_around(w, u, v);
    const real q = near.q[AROUND / 2];
    if (q <= 0) return;
    near.apart = APART * q / w->reduced->capture.views[view].camera.fx;
    const int n = choose_surface(w, &near, x, y);
    FfpPlane plane = blend(&near, n);
    plane.qx *= w->across;
    plane.qy *= w->down;
    ffp_plane_normal(&plane, &w->full->camera, (real)x + 0.5F, (real)y + 0.5F, out->normal + 3 * i);
    out->depth[i] = 1 / plane.q0;
    const size_t cell = ((size_t)view * (size_t)w->height + (size_t)((int)v + n / 3 - 1)) * (size_t)w->width +
                        (size_t)((int)u + n % 3 - 1);
    const real lit = w->observed->lit[i], lit_there = start->lit[cell];
    if (lit >= FFP_LIT_MIN && lit_there >= FFP_LIT_MIN)
        out->confidence[i] = fmin(start->confidence[cell] / lit_there, 1) * lit;
}

void ffp_enlarge(const FfpEnlarged *out, const FfpReduced *reduced, const FfpView *full, int view,
                 const FfpObservation *observed, const FfpBlurred *patterns) {
    Work w = {.reduced = reduced,
              .full = full,
              .observed = observed,
              .patterns = patterns,
              .planes = fit_planes(reduced, view),
              .width = reduced->start.width,
              .height = reduced->start.height,
              .across = (real)reduced->start.width / (real)observed->width,
              .down = (real)reduced->start.height / (real)observed->height};
    for (int y = 0; y < observed->height; y++)
        for (int x = 0; x < observed->width; x++)
            if (full->coverage.data[(size_t)y * (size_t)observed->width + (size_t)x] > 0)
                enlarge_pixel(out, &w, view, x, y);
    ffp_free(w.planes);
}
