// The integral S(x, y) of a pattern that is constant within each pixel is bilinear within each cell of the
// summed-area table, so interpolating the table is exact. A box's mean is
//     (S(x1,y1) - S(x0,y1) - S(x1,y0) + S(x0,y0)) / (du dv),   x0,x1 = u -+ du/2,   y0,y1 = v -+ dv/2.
#include "image/lookup.h"

#include <stdlib.h>

#include "base/arena.h"
#include "base/device.h"

// The two table entries that interpolate S at a coordinate, with weights; `slope` is 0 where the coordinate
// was clamped to the pattern's edge (the pattern is black outside: S grows no further).
typedef struct Edge {
    int first;
    double weight; // of first + 1; first has 1 - weight
    double slope;
} Edge;

static Edge edge_at(double x, int n) {
    if (!(x > 0)) return (Edge){0, 0, 0};
    if (x >= n) return (Edge){n - 1, 1, 0};
    return (Edge){(int)x, x - (int)x, 1};
}

typedef struct Box {
    Edge x[2], y[2];
    double scale; // 1 / area
} Box;

static Box box_at(const FfpSummed *summed, real u, real v, real du, real dv) {
    const double width = du > 1 ? (double)du : 1, height = dv > 1 ? (double)dv : 1;
    return (Box){
        {edge_at((double)u - width / 2, summed->width), edge_at((double)u + width / 2, summed->width)},
        {edge_at((double)v - height / 2, summed->height), edge_at((double)v + height / 2, summed->height)},
        1 / (width * height)};
}

FfpSummed ffp_summed_new(const FfpImage *rgb) {
    FfpSummed summed = {rgb->width, rgb->height, NULL};
    const size_t stride = ((size_t)rgb->width + 1) * 3;
    summed.sum = ffp_alloc(stride * ((size_t)rgb->height + 1), sizeof(double));
    for (int y = 0; y < rgb->height; y++) {
        const real *from = rgb->data + (size_t)y * (size_t)rgb->width * 3;
        const double *above = summed.sum + (size_t)y * stride;
        double *to = summed.sum + (size_t)(y + 1) * stride, row[3] = {0, 0, 0};
        for (size_t x = 0; x < (size_t)rgb->width; x++) {
            for (size_t c = 0; c < 3; c++) {
                row[c] += (double)from[3 * x + c];
                to[3 * (x + 1) + c] = above[3 * (x + 1) + c] + row[c];
            }
        }
    }
    return summed;
}

void ffp_summed_free(FfpSummed *summed) {
    if (summed == NULL) return;
    ffp_memory_free(summed->sum);
    *summed = (FfpSummed){0};
}

// Adds to out[3] the row's S at `high` minus its S at `low`.
static void row_difference(const double *row, const Edge *low, const Edge *high, double weight,
                           double out[3]) {
    const double *a = row + 3 * (size_t)low->first, *b = row + 3 * (size_t)high->first;
    for (int c = 0; c < 3; c++) {
        out[c] +=
            weight * ((b[c] + (b[3 + c] - b[c]) * high->weight) - (a[c] + (a[3 + c] - a[c]) * low->weight));
    }
}

void ffp_lookup(const FfpSummed *summed, real u, real v, real du, real dv, real out[3]) {
    const Box box = box_at(summed, u, v, du, dv);
    const size_t stride = ((size_t)summed->width + 1) * 3;
    double total[3] = {0, 0, 0};
    for (int j = 0; j < 2; j++) {
        const double *row = summed->sum + (size_t)box.y[j].first * stride;
        const double sign = j == 1 ? 1 : -1;
        row_difference(row, &box.x[0], &box.x[1], sign * (1 - box.y[j].weight), total);
        row_difference(row + stride, &box.x[0], &box.x[1], sign * box.y[j].weight, total);
    }
    for (int c = 0; c < 3; c++) out[c] = (real)(total[c] * box.scale);
}

void ffp_lookup_backward_position(const FfpSummed *summed, real u, real v, real du, real dv,
                                  const real grad[3], real *grad_u, real *grad_v) {
    const Box box = box_at(summed, u, v, du, dv);
    const size_t stride = ((size_t)summed->width + 1) * 3;
    double sum_u = 0, sum_v = 0;
    for (int j = 0; j < 2; j++) {
        for (int i = 0; i < 2; i++) {
            const Edge *x = &box.x[i], *y = &box.y[j];
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

void ffp_lookup_backward_pattern(FfpSummed *grad_sum, real u, real v, real du, real dv, const real grad[3]) {
    const Box box = box_at(grad_sum, u, v, du, dv);
    const size_t stride = ((size_t)grad_sum->width + 1) * 3;
    for (int j = 0; j < 2; j++) {
        for (int i = 0; i < 2; i++) {
            const Edge *x = &box.x[i], *y = &box.y[j];
            const double scale = i == j ? box.scale : -box.scale;
            double *top = grad_sum->sum + (size_t)y->first * stride + 3 * (size_t)x->first,
                   *bottom = top + stride;
            for (int c = 0; c < 3; c++) {
                const double g = scale * (double)grad[c];
                top[c] += g * (1 - x->weight) * (1 - y->weight);
                top[3 + c] += g * x->weight * (1 - y->weight);
                bottom[c] += g * (1 - x->weight) * y->weight;
                bottom[3 + c] += g * x->weight * y->weight;
            }
        }
    }
}

void ffp_lookup_gather_pattern(const FfpSummed *grad_sum, FfpImage *grad_pattern) {
    // A pixel is part of every sum to its right and below: the adjoint of the running sums is running sums
    // backwards.
    const size_t width = (size_t)grad_sum->width, stride = (width + 1) * 3;
    double *below =
        ffp_alloc(stride, sizeof(double)); // sums over all rows from y + 1 down, columns from x + 1 on
    for (int y = grad_sum->height - 1; y >= 0; y--) {
        const double *row = grad_sum->sum + (size_t)(y + 1) * stride;
        double run[3] = {0, 0, 0};
        for (size_t x = width; x-- > 0;) {
            for (size_t c = 0; c < 3; c++) {
                run[c] += row[3 * (x + 1) + c];
                below[3 * x + c] += run[c];
                grad_pattern->data[((size_t)y * width + x) * 3 + c] = (real)below[3 * x + c];
            }
        }
    }
    free(below);
}
