// Planes of least squares through the neighbours of FFP_MATCH_LANES pixels at a time
// (engine/match/surface.h), one text for the CPU and the GPU.
#ifndef FFP_MATCH_PLANE_FORMULA_H
#define FFP_MATCH_PLANE_FORMULA_H

#include "engine/match/surface.h"

#define FFP_PLANE_ROUNDS 3       // of weighing and fitting
#define FFP_PLANE_RESIDUAL 0.35F // footprints off the plane at which a neighbour counts half
#define FFP_PLANE_REGULAR                                                                                    \
    1e-3F // share of the weights that holds the slopes at zero where neighbours say nothing

typedef real FfpLanes[FFP_MATCH_LANES];

// Weighted sums over the neighbours in (1, dx, dy) and the inverse depth q, which is taken relative to the
// pixel's own: fp32 serves.
typedef struct FfpPlaneSums {
    FfpLanes w, x, y, xx, xy, yy, q, xq, yq;
} FfpPlaneSums;

// The pixels in work: their depths, and the planes so far, relative to the pixel's own inverse depth.
typedef struct FfpPlaneFit {
    FfpLanes z, inverse, footprint, per_unit; // per_unit: of residuals in inverse depth
    FfpLanes q0, qx, qy;
} FfpPlaneFit;

// Adds the neighbours of one row. `refit`: weighs them down by their distance from the plane.
FFP_FORMULA void ffp_plane_add_row(FfpPlaneSums *sums, const FfpSheet *sheet, const FfpPlaneFit *fit,
                                   size_t first, int dy, bool refit) {
    FfpLanes w0 = {0}, w1 = {0}, w2 = {0}, r0 = {0}, r1 = {0};
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
FFP_FORMULA void ffp_plane_solve(FfpPlaneFit *fit, const FfpPlaneSums *s) {
    for (int n = 0; n < FFP_MATCH_LANES; n++) {
        const bool known = s->w[n] > 0;
        const real w = known ? s->w[n] : 1, mx = s->x[n] / w, my = s->y[n] / w, mq = s->q[n] / w;
        const real hold = FFP_PLANE_REGULAR * w, a = s->xx[n] - w * mx * mx + hold,
                   b = s->xy[n] - w * mx * my, c = s->yy[n] - w * my * my + hold;
        const real p = s->xq[n] - w * mx * mq, q = s->yq[n] - w * my * mq, det = a * c - b * b;
        const real sx = (c * p - b * q) / det, sy = (a * q - b * p) / det;
        fit->q0[n] = known ? mq - sx * mx - sy * my : fit->q0[n];
        fit->qx[n] = known ? sx : fit->qx[n];
        fit->qy[n] = known ? sy : fit->qy[n];
    }
}

// Of ffp_fit_planes.
FFP_FORMULA void ffp_planes_at(FfpPlane planes[FFP_MATCH_LANES], const FfpSheet *sheet, int x, int y) {
    const size_t first = (size_t)y * (size_t)sheet->stride + (size_t)x,
                 own = first + (size_t)sheet->reach * ((size_t)sheet->stride + 1);
    FfpPlaneFit fit;
    for (int n = 0; n < FFP_MATCH_LANES; n++) {
        fit.z[n] = sheet->depth[own + (size_t)n];
        fit.inverse[n] = sheet->inverse[own + (size_t)n];
        fit.footprint[n] = fit.z[n] / sheet->focal;
        fit.q0[n] = fit.qx[n] = fit.qy[n] = 0;
        fit.per_unit[n] = fit.z[n] > 0 ? fit.z[n] * sheet->focal / FFP_PLANE_RESIDUAL : 0;
    }
    for (int round = 0; round < FFP_PLANE_ROUNDS; round++) {
        FfpPlaneSums sums = {{0}, {0}, {0}, {0}, {0}, {0}, {0}, {0}, {0}};
        for (int dy = -sheet->reach; dy <= sheet->reach; dy++)
            ffp_plane_add_row(&sums, sheet, &fit, first, dy, round > 0);
        ffp_plane_solve(&fit, &sums);
    }
    for (int n = 0; n < FFP_MATCH_LANES; n++) {
        const bool there = fit.z[n] > 0 && x + n < sheet->width;
        planes[n].q0 = there ? fit.inverse[n] + fit.q0[n] : 0;
        planes[n].qx = there ? fit.qx[n] : 0;
        planes[n].qy = there ? fit.qy[n] : 0;
    }
}

#endif
