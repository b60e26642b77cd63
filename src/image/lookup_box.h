// The mean of a pattern over a box, and its slope, one text for the CPU and the GPU.
//
// The integral S(x, y) of a pattern that is constant within each pixel is bilinear within each cell of the
// summed-area table, so interpolating the table is exact. A box's mean is
//     (S(x1,y1) - S(x0,y1) - S(x1,y0) + S(x0,y0)) / (du dv),   x0,x1 = u -+ du/2,   y0,y1 = v -+ dv/2.
#ifndef FFP_IMAGE_LOOKUP_BOX_H
#define FFP_IMAGE_LOOKUP_BOX_H

#include "image/lookup.h"

// The two table entries that interpolate S at a coordinate, with weights; `slope` is 0 where the coordinate
// was clamped to the pattern's edge (the pattern is black outside: S grows no further).
typedef struct FfpEdge {
    int first;
    double weight; // of first + 1; first has 1 - weight
    double slope;
} FfpEdge;

FFP_FORMULA FfpEdge ffp_edge_at(double x, int n) {
    FfpEdge edge = {0, 0, 0};
    if (x >= n)
        edge.first = n - 1, edge.weight = 1;
    else if (x > 0)
        edge.first = (int)x, edge.weight = x - (int)x, edge.slope = 1;
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

// The entries of S that interpolate it at (x, y).
FFP_FORMULA const double *ffp_corner(const FfpSummed *summed, const FfpEdge *x, const FfpEdge *y) {
    const size_t stride = ((size_t)summed->width + 1) * FFP_SUMMED_CHANNELS;
    return summed->sum + (size_t)y->first * stride + FFP_SUMMED_CHANNELS * (size_t)x->first;
}

// From one edge to the other, within the pattern.
FFP_FORMULA double ffp_span(const FfpEdge edges[2]) {
    return edges[1].first - edges[0].first + (edges[1].weight - edges[0].weight);
}

FFP_FORMULA void ffp_sum_corners(const FfpSummed *summed, const FfpBox *box, double sum[]) {
    const size_t stride = ((size_t)summed->width + 1) * FFP_SUMMED_CHANNELS;
    for (int k = 0; k < 4; k++) {
        const FfpEdge *x = &box->x[k & 1], *y = &box->y[k >> 1];
        const double sign = k == 0 || k == 3 ? 1 : -1, low = sign * (1 - y->weight), high = sign * y->weight;
        const double *top = ffp_corner(summed, x, y), *bottom = top + stride;
        for (int c = 0; c < FFP_SUMMED_CHANNELS; c++) {
            const double upper = top[c] + (top[FFP_SUMMED_CHANNELS + c] - top[c]) * x->weight;
            const double lower = bottom[c] + (bottom[FFP_SUMMED_CHANNELS + c] - bottom[c]) * x->weight;
            sum[c] += low * upper + high * lower;
        }
    }
}

// ffp_lookup
FFP_FORMULA void ffp_box_mean(const FfpSummed *summed, real u, real v, real du, real dv, real out[3]) {
    const FfpBox box = ffp_box_at(summed, u, v, du, dv);
    double sum[FFP_SUMMED_CHANNELS] = {0, 0, 0, 0};
    if (summed->plain)
        for (int c = 0; c < 3; c++) sum[c] = summed->colour[c] * ffp_span(box.x) * ffp_span(box.y);
    else
        ffp_sum_corners(summed, &box, sum);
    for (int c = 0; c < 3; c++) out[c] = (real)(sum[c] * box.scale);
}

// Sums over a box's corners: S itself, and its slopes along x and y.
typedef struct FfpBoxSums {
    double s[FFP_SUMMED_CHANNELS], along_x[FFP_SUMMED_CHANNELS], along_y[FFP_SUMMED_CHANNELS];
} FfpBoxSums;

FFP_FORMULA void ffp_add_corner(const FfpSummed *summed, const FfpEdge *x, const FfpEdge *y, double sign,
                                FfpBoxSums *sums) {
    const double *top = ffp_corner(summed, x, y);
    const double *bottom = top + ((size_t)summed->width + 1) * FFP_SUMMED_CHANNELS;
    const double x_slope = sign * x->slope, y_slope = sign * y->slope;
    for (int c = 0; c < FFP_SUMMED_CHANNELS; c++) {
        const double upper = top[FFP_SUMMED_CHANNELS + c] - top[c], left = bottom[c] - top[c];
        const double twist = bottom[FFP_SUMMED_CHANNELS + c] - bottom[c] - upper;
        const double down = left + twist * x->weight;
        sums->s[c] += sign * (top[c] + upper * x->weight + down * y->weight);
        sums->along_x[c] += x_slope * (upper + twist * y->weight);
        sums->along_y[c] += y_slope * down;
    }
}

FFP_FORMULA void ffp_sum_plain(const FfpSummed *summed, const FfpBox *box, FfpBoxSums *sums) {
    const double width = ffp_span(box->x), height = ffp_span(box->y);
    for (int c = 0; c < 3; c++) {
        sums->s[c] = summed->colour[c] * width * height;
        sums->along_x[c] = summed->colour[c] * (box->x[1].slope - box->x[0].slope) * height;
        sums->along_y[c] = summed->colour[c] * (box->y[1].slope - box->y[0].slope) * width;
    }
}

// ffp_box_mean, and how each channel changes with u and with v.
FFP_FORMULA void ffp_box_slopes(const FfpSummed *summed, real u, real v, real du, real dv, real out[3],
                                real along_u[3], real along_v[3]) {
    const FfpBox box = ffp_box_at(summed, u, v, du, dv);
    FfpBoxSums sums = {{0}, {0}, {0}};
    if (summed->plain)
        ffp_sum_plain(summed, &box, &sums);
    else
        for (int k = 0; k < 4; k++)
            ffp_add_corner(summed, &box.x[k & 1], &box.y[k >> 1], k == 0 || k == 3 ? 1 : -1, &sums);
    for (int c = 0; c < 3; c++) {
        out[c] = (real)(sums.s[c] * box.scale);
        along_u[c] = (real)(sums.along_x[c] * box.scale);
        along_v[c] = (real)(sums.along_y[c] * box.scale);
    }
}

#endif
