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

// Adds to out[3] the row's S at `high` minus its S at `low`.
FFP_FORMULA void ffp_row_difference(const double *row, const FfpEdge *low, const FfpEdge *high, double weight,
                                    double out[3]) {
    const double *a = row + 3 * (size_t)low->first, *b = row + 3 * (size_t)high->first;
    for (int c = 0; c < 3; c++) {
        out[c] +=
            weight * ((b[c] + (b[3 + c] - b[c]) * high->weight) - (a[c] + (a[3 + c] - a[c]) * low->weight));
    }
}

// ffp_lookup
FFP_FORMULA void ffp_box_mean(const FfpSummed *summed, real u, real v, real du, real dv, real out[3]) {
    const FfpBox box = ffp_box_at(summed, u, v, du, dv);
    const size_t stride = ((size_t)summed->width + 1) * 3;
    double total[3] = {0, 0, 0};
    for (int j = 0; j < 2; j++) {
        const double *row = summed->sum + (size_t)box.y[j].first * stride;
        const double sign = j == 1 ? 1 : -1;
        ffp_row_difference(row, &box.x[0], &box.x[1], sign * (1 - box.y[j].weight), total);
        ffp_row_difference(row + stride, &box.x[0], &box.x[1], sign * box.y[j].weight, total);
    }
    for (int c = 0; c < 3; c++) out[c] = (real)(total[c] * box.scale);
}

// ffp_lookup_backward_position
FFP_FORMULA void ffp_box_mean_backward(const FfpSummed *summed, real u, real v, real du, real dv,
                                       const real grad[3], real *grad_u, real *grad_v) {
    const FfpBox box = ffp_box_at(summed, u, v, du, dv);
    const size_t stride = ((size_t)summed->width + 1) * 3;
    double sum_u = 0, sum_v = 0;
    for (int j = 0; j < 2; j++) {
        for (int i = 0; i < 2; i++) {
            const FfpEdge *x = &box.x[i], *y = &box.y[j];
            const double sign = i == j ? 1 : -1;
            const double *top = summed->sum + (size_t)y->first * stride + 3 * (size_t)x->first,
                         *bottom = top + stride;
            for (int c = 0; c < 3; c++) {
                const double upper = top[3 + c] - top[c], lower = bottom[3 + c] - bottom[c];
                const double left = bottom[c] - top[c], right = bottom[3 + c] - top[3 + c];
                sum_u += (double)grad[c] * sign * x->slope * (upper + (lower - upper) * y->weight);
                sum_v += (double)grad[c] * sign * y->slope * (left + (right - left) * x->weight);
            }
        }
    }
    *grad_u += (real)(sum_u * box.scale);
    *grad_v += (real)(sum_v * box.scale);
}

#endif
