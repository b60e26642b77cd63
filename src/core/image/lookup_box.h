// The mean of a pattern over a box, and its slope, one text for the CPU and the GPU.
//
// The integral S(x, y) of a pattern that is constant within each pixel is bilinear within each cell of the
// summed-area table, so interpolating the table is exact. A box's mean is
//     (S(x1,y1) - S(x0,y1) - S(x1,y0) + S(x0,y0)) / (du dv),   x0,x1 = u -+ du/2,   y0,y1 = v -+ dv/2.
#ifndef FFP_IMAGE_LOOKUP_BOX_H
#define FFP_IMAGE_LOOKUP_BOX_H

#include "core/base/four.h"
#include "core/image/lookup.h"

// The two table entries that interpolate S at a coordinate, with weights; `slope` is 0 where the coordinate
// was clamped to the pattern's edge (the pattern is black outside: S grows no further).
typedef struct FfpEdge {
    int first;
    double weight; // of first + 1; first has 1 - weight
    double slope;
} FfpEdge;

FFP_FORMULA FfpEdge ffp_edge_at(double x, int n) {
    FfpEdge edge = {0, 0, 0};
    if (x >= n) {
        edge.first = n - 1;
        edge.weight = 1;
    } else if (x > 0) {
        edge.first = (int)x;
        edge.weight = x - (int)x;
        edge.slope = 1;
    }
    return edge;
}

typedef struct FfpBox {
    FfpEdge x[2], y[2];
    double scale; // 1 / area
} FfpBox;

FFP_FORMULA FfpBox ffp_box_at(const FfpSummed *summed, real u, real v, real du, real dv) {
    const double width = du > 1 ? (double)du : 1, height = dv > 1 ? (double)dv : 1;
    FfpBox box;
    box.x[0] = ffp_edge_at((double)u - width / 2, summed->width);
    box.x[1] = ffp_edge_at((double)u + width / 2, summed->width);
    box.y[0] = ffp_edge_at((double)v - height / 2, summed->height);
    box.y[1] = ffp_edge_at((double)v + height / 2, summed->height);
    box.scale = 1 / (width * height);
    return box;
}

// Entry (x, y) of the table.
FFP_FORMULA const FfpFour *ffp_entry(const FfpSummed *summed, int x, int y) {
    return (const FfpFour *)summed->sum + ((size_t)summed->width + 1) * (size_t)y + (size_t)x;
}

// From one edge to the other, within the pattern.
FFP_FORMULA double ffp_span(const FfpEdge edges[2]) {
    return edges[1].first - edges[0].first + (edges[1].weight - edges[0].weight);
}

// S at a corner.
FFP_FORMULA FfpFour ffp_corner(const FfpSummed *summed, const FfpEdge *x, const FfpEdge *y) {
    const FfpFour *top = ffp_entry(summed, x->first, y->first),
                  *bottom = ffp_entry(summed, x->first, y->first + 1);
    const FfpFour upper = top[0] + (top[1] - top[0]) * x->weight;
    const FfpFour lower = bottom[0] + (bottom[1] - bottom[0]) * x->weight;
    return upper + (lower - upper) * y->weight;
}

// True if the pattern shows the same all over the box and around it: one colour, and no edge.
FFP_FORMULA bool ffp_box_plain(const FfpSummed *summed, real u, real v, real du, real dv) {
    const real x = (du > 1 ? du : 1) / 2, y = (dv > 1 ? dv : 1) / 2;
    return summed->plain && u > x && v > y && u + x < (real)summed->width && v + y < (real)summed->height;
}

// The mean over a box of a pattern that is not plain.
FFP_FORMULA void ffp_mean_in(const FfpSummed *summed, const FfpBox *box, real out[3]) {
    const FfpFour mean =
        ((ffp_corner(summed, &box->x[1], &box->y[1]) - ffp_corner(summed, &box->x[0], &box->y[1])) -
         (ffp_corner(summed, &box->x[1], &box->y[0]) - ffp_corner(summed, &box->x[0], &box->y[0]))) *
        box->scale;
    for (int c = 0; c < 3; c++) out[c] = (real)mean[c];
}

// ffp_lookup
FFP_FORMULA void ffp_box_mean(const FfpSummed *summed, real u, real v, real du, real dv, real out[3]) {
    if (ffp_box_plain(summed, u, v, du, dv)) {
        for (int c = 0; c < 3; c++) out[c] = (real)summed->colour[c];
        return;
    }
    const FfpBox box = ffp_box_at(summed, u, v, du, dv);
    if (summed->plain) {
        const double area = ffp_span(box.x) * ffp_span(box.y) * box.scale;
        for (int c = 0; c < 3; c++) out[c] = (real)(summed->colour[c] * area);
        return;
    }
    ffp_mean_in(summed, &box, out);
}

FFP_FORMULA void ffp_plain_slopes(const FfpSummed *summed, const FfpBox *box, real out[3], real along_u[3],
                                  real along_v[3]) {
    const double width = ffp_span(box->x), height = ffp_span(box->y);
    for (int c = 0; c < 3; c++) {
        const double scaled = summed->colour[c] * box->scale;
        out[c] = (real)(scaled * width * height);
        along_u[c] = (real)(scaled * (box->x[1].slope - box->x[0].slope) * height);
        along_v[c] = (real)(scaled * (box->y[1].slope - box->y[0].slope) * width);
    }
}

// S and its slopes at a corner, times `scale`, added.
FFP_FORMULA void ffp_add_corner(const FfpSummed *summed, const FfpEdge *x, const FfpEdge *y, double scale,
                                FfpFour sums[3]) {
    const FfpFour *top = ffp_entry(summed, x->first, y->first),
                  *bottom = ffp_entry(summed, x->first, y->first + 1);
    const FfpFour along_x = top[1] - top[0], twist = (bottom[1] - bottom[0]) - along_x;
    const FfpFour along_y = (bottom[0] - top[0]) + twist * x->weight;
    sums[0] = sums[0] + (top[0] + along_x * x->weight + along_y * y->weight) * scale;
    sums[1] = sums[1] + (along_x + twist * y->weight) * (scale * x->slope);
    sums[2] = sums[2] + along_y * (scale * y->slope);
}

// ffp_box_mean, and how each channel changes with u and with v.
FFP_FORMULA void ffp_box_slopes(const FfpSummed *summed, real u, real v, real du, real dv, real out[3],
                                real along_u[3], real along_v[3]) {
    if (ffp_box_plain(summed, u, v, du, dv)) {
        for (int c = 0; c < 3; c++) {
            out[c] = (real)summed->colour[c];
            along_u[c] = along_v[c] = 0;
        }
        return;
    }
    const FfpBox box = ffp_box_at(summed, u, v, du, dv);
    if (summed->plain) {
        ffp_plain_slopes(summed, &box, out, along_u, along_v);
        return;
    }
    FfpFour sums[3] = {{0}, {0}, {0}};
    for (int k = 0; k < 4; k++)
        ffp_add_corner(summed, &box.x[k & 1], &box.y[k >> 1], k == 0 || k == 3 ? box.scale : -box.scale,
                       sums);
    for (int c = 0; c < 3; c++) {
        out[c] = (real)sums[0][c];
        along_u[c] = (real)sums[1][c];
        along_v[c] = (real)sums[2][c];
    }
}

#endif
