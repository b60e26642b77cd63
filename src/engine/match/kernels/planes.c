// Planes of least squares through the neighbours of several pixels at a time (engine/match/surface.h).
#include <stdbool.h>
#include "engine/match/kernels/kernels.h"

#define ROUNDS 3       // of weighing and fitting
#define RESIDUAL 0.35F // footprints off the plane at which a neighbour counts half
#define REGULAR 1e-3F  // share of the weights that holds the slopes at zero where neighbours say nothing

typedef real Lanes[FFP_MATCH_LANES];

// Weighted sums over the neighbours in (1, dx, dy) and the inverse depth q, which is taken relative to the
// pixel's own: fp32 serves.
typedef struct Sums {
    Lanes w, x, y, xx, xy, yy, q, xq, yq;
} Sums;

// The pixels in work: their depths, and the planes so far, relative to the pixel's own inverse depth.
typedef struct Fit {
    Lanes z, inverse, footprint, per_unit; // per_unit: of residuals in inverse depth
    Lanes q0, qx, qy;
} Fit;

// Adds the neighbours of one row. `refit`: weighs them down by their distance from the plane.
static void add_row(Sums *sums, const FfpSheet *sheet, const Fit *fit, size_t first, int dy, bool refit) {
    Lanes w0 = {0}, w1 = {0}, w2 = {0}, r0 = {0}, r1 = {0};
    const int reach = sheet->reach;
    const real y = (real)dy;
    for (int dx = -reach; dx <= reach; dx++) {
        const size_t at = first + (size_t)(dy + reach) * (size_t)sheet->stride + (size_t)(dx + reach);
        const real *depth = sheet->depth + at, *inverse = sheet->inverse + at, *weight = sheet->weight + at;
        const int neighbour = (dy + reach) * (2 * reach + 1) + dx + reach;
        const real nearness = sheet->nearness[neighbour], jump = sheet->jump[neighbour], x = (real)dx;
        for (int n = 0; n < FFP_MATCH_LANES; n++) {
            const real step = depth[n] - fit->z[n], limit = jump * fit->footprint[n];
            const real q = inverse[n] - fit->inverse[n];
            const real off = (q - fit->q0[n] - fit->qx[n] * x - fit->qy[n] * y) * fit->per_unit[n];
            const real share = refit ? nearness / (1 + off * off) : nearness;
            const real w = ((step <= limit) & (-step <= limit)) ? weight[n] * share : 0;
            w0[n] += w;
            w1[n] += w * x;
            w2[n] += w * x * x;
            r0[n] += w * q;
            r1[n] += w * x * q;
        }
    }
    for (int n = 0; n < FFP_MATCH_LANES; n++) {
        sums->w[n] += w0[n];
        sums->x[n] += w1[n];
        sums->y[n] += y * w0[n];
        sums->xx[n] += w2[n];
        sums->xy[n] += y * w1[n];
        sums->yy[n] += y * y * w0[n];
        sums->q[n] += r0[n];
        sums->xq[n] += r1[n];
        sums->yq[n] += y * r0[n];
    }
}

// The planes of least squares, where there are neighbours. Sums about the means keep the elimination
// well-conditioned; the slopes are held towards zero a little.
static void solve(Fit *fit, const Sums *s) {
    for (int n = 0; n < FFP_MATCH_LANES; n++) {
        const bool known = s->w[n] > 0;
        const real w = known ? s->w[n] : 1, mx = s->x[n] / w, my = s->y[n] / w, mq = s->q[n] / w;
        const real hold = REGULAR * w, a = s->xx[n] - w * mx * mx + hold, b = s->xy[n] - w * mx * my,
                   c = s->yy[n] - w * my * my + hold;
        const real p = s->xq[n] - w * mx * mq, q = s->yq[n] - w * my * mq, det = a * c - b * b;
        const real sx = (c * p - b * q) / det, sy = (a * q - b * p) / det;
        fit->q0[n] = known ? mq - sx * mx - sy * my : fit->q0[n];
        fit->qx[n] = known ? sx : fit->qx[n];
        fit->qy[n] = known ? sy : fit->qy[n];
    }
}

void FFP_K(fit_planes)(FfpPlane planes[FFP_MATCH_LANES], const FfpSheet *sheet, int x, int y) {
    const size_t first = (size_t)y * (size_t)sheet->stride + (size_t)x,
                 own = first + (size_t)sheet->reach * ((size_t)sheet->stride + 1);
    Fit fit = {.q0 = {0}};
    for (int n = 0; n < FFP_MATCH_LANES; n++) {
        fit.z[n] = sheet->depth[own + (size_t)n];
        fit.inverse[n] = sheet->inverse[own + (size_t)n];
        fit.footprint[n] = fit.z[n] / sheet->focal;
        fit.per_unit[n] = fit.z[n] > 0 ? fit.z[n] * sheet->focal / RESIDUAL : 0;
    }
    for (int round = 0; round < ROUNDS; round++) {
        Sums sums = {.w = {0}};
        for (int dy = -sheet->reach; dy <= sheet->reach; dy++)
            add_row(&sums, sheet, &fit, first, dy, round > 0);
        solve(&fit, &sums);
    }
    for (int n = 0; n < FFP_MATCH_LANES; n++) {
        const bool there = fit.z[n] > 0 && x + n < sheet->width;
        planes[n] = there ? (FfpPlane){fit.inverse[n] + fit.q0[n], fit.qx[n], fit.qy[n]} : (FfpPlane){0};
    }
}
