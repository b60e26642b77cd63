// Summed-area tables on the CPU; what is made of them is in lookup_box.h.
#include "core/image/lookup.h"
#include <omp.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/device.h"
#include "core/base/integer.h"
#include "core/image/lookup_box.h"

static size_t entries_of(int width, int height) {
    return ((size_t)width + 1) * ((size_t)height + 1);
}

FfpSummed ffp_summed_zeros(int width, int height) {
    return (FfpSummed){.width = width,
                       .height = height,
                       .sum = ffp_alloc(entries_of(width, height), FFP_SUMMED_CHANNELS * sizeof(double))};
}

static void find_plain(const FfpImage *rgb, FfpSummed *summed) {
    const size_t count = 3 * (size_t)rgb->width * (size_t)rgb->height;
    summed->plain = false;
    for (size_t i = 3; i < count; i++)
        if (rgb->data[i] != rgb->data[i - 3]) return;
    summed->plain = count > 0;
    for (int c = 0; c < 3 && count; c++) summed->colour[c] = (double)rgb->data[c];
}

// Strips of columns are filled side by side; the sums of a row begin at a strip's left edge with what is left
// of it, added up from the row's first pixel in every strip alike.
typedef double Edge[3];

// [strips,height]: of each row, the sums left of each strip.
static Edge *sums_at_edges(const FfpImage *rgb, int strips) {
    Edge *edges = ffp_alloc((size_t)strips * (size_t)rgb->height, sizeof *edges);
    const size_t width = (size_t)rgb->width, height = (size_t)rgb->height;
#pragma omp parallel for schedule(static) if (strips > 1)
    for (size_t y = 0; y < height; y++) {
        const real *from = rgb->data + y * width * 3;
        Edge row = {0};
        size_t x = 0;
        for (size_t s = 1; s < (size_t)strips; s++) {
            for (; x < s * width / (size_t)strips; x++)
                for (size_t c = 0; c < 3; c++) row[c] += (double)from[3 * x + c];
            memcpy(edges[s * height + y], row, sizeof row);
        }
    }
    return edges;
}

// Columns first to end - 1 of the picture; edge: [height].
static void fill_strip(FfpSummed *summed, const FfpImage *rgb, size_t first, size_t end, const Edge *edge) {
    enum { N = FFP_SUMMED_CHANNELS };
    const size_t width = (size_t)rgb->width, stride = (width + 1) * N;
    for (size_t y = 0; y < (size_t)rgb->height; y++) {
        const real *from = rgb->data + y * width * 3;
        const double *above = summed->sum + y * stride;
        double *to = summed->sum + (y + 1) * stride, row[3];
        memcpy(row, edge[y], sizeof row);
        if (first == 0) memset(to, 0, N * sizeof *to);
        for (size_t x = first; x < end; x++) {
            for (size_t c = 0; c < 3; c++) {
                row[c] += (double)from[3 * x + c];
                to[N * (x + 1) + c] = above[N * (x + 1) + c] + row[c];
            }
            to[N * (x + 1) + 3] = 0;
        }
    }
}

void ffp_summed_fill(FfpSummed *summed, const FfpImage *rgb) {
    enum { N = FFP_SUMMED_CHANNELS, LEAST = 64 }; // columns of a strip
    const size_t stride = ((size_t)rgb->width + 1) * N;
    find_plain(rgb, summed);
    if (summed->plain) {
        ffp_memory_free(summed->sum);
        summed->sum = NULL;
        summed->width = rgb->width;
        summed->height = rgb->height;
        return;
    }
    if (!summed->sum || summed->width != rgb->width || summed->height != rgb->height) {
        ffp_memory_free(summed->sum);
        *summed = (FfpSummed){.width = rgb->width, .height = rgb->height};
        summed->sum = ffp_take(entries_of(rgb->width, rgb->height), N * sizeof(double));
        memset(summed->sum, 0, stride * sizeof(double));
    }
    const int strips = ffp_smaller(omp_in_parallel() ? 1 : omp_get_max_threads(), rgb->width / LEAST + 1);
    Edge *edges = sums_at_edges(rgb, strips);
#pragma omp parallel for schedule(static) if (strips > 1)
    for (int s = 0; s < strips; s++)
        fill_strip(summed, rgb, (size_t)s * (size_t)rgb->width / (size_t)strips,
                   ((size_t)s + 1) * (size_t)rgb->width / (size_t)strips,
                   edges + (size_t)s * (size_t)rgb->height);
    ffp_free(edges);
}

FfpSummed ffp_summed_new(const FfpImage *rgb) {
    FfpSummed summed = {0};
    ffp_summed_fill(&summed, rgb);
    return summed;
}

FfpSummed ffp_summed_uploaded(const FfpSummed *host) {
    FfpSummed there = *host;
    if (host->plain) return there;
    there.sum = ffp_memory_uploaded(host->sum, entries_of(host->width, host->height),
                                    FFP_SUMMED_CHANNELS * sizeof(double));
    return there;
}

void ffp_summed_free(FfpSummed *summed) {
    if (!summed) return;
    ffp_memory_free(summed->sum);
    *summed = (FfpSummed){0};
}

void ffp_lookup(const FfpSummed *summed, real u, real v, real du, real dv, real out[3]) {
    ffp_box_mean(summed, u, v, du, dv, out);
}

void ffp_lookup_backward_pattern(FfpSummed *grad_sum, real u, real v, real du, real dv, const real grad[3]) {
    const FfpBox box = ffp_box_at(grad_sum, u, v, du, dv);
    enum { N = FFP_SUMMED_CHANNELS };
    const size_t stride = ((size_t)grad_sum->width + 1) * N;
    for (int j = 0; j < 2; j++) {
        for (int i = 0; i < 2; i++) {
            const FfpEdge *x = &box.x[i], *y = &box.y[j];
            const double scale = i == j ? box.scale : -box.scale;
            double *top = grad_sum->sum + (size_t)y->first * stride + N * (size_t)x->first,
                   *bottom = top + stride;
            for (int c = 0; c < 3; c++) {
                const double g = scale * (double)grad[c];
                top[c] += g * (1 - x->weight) * (1 - y->weight);
                top[N + c] += g * x->weight * (1 - y->weight);
                bottom[c] += g * (1 - x->weight) * y->weight;
                bottom[N + c] += g * x->weight * y->weight;
            }
        }
    }
}

void ffp_lookup_gather_pattern(const FfpSummed *grad_sum, FfpImage *grad_pattern) {
    // A pixel is part of every sum to its right and below: the adjoint of the running sums is running sums
    // backwards.
    enum { N = FFP_SUMMED_CHANNELS };
    const size_t width = (size_t)grad_sum->width, stride = (width + 1) * N;
    double *below = ffp_alloc((width + 1) * 3,
                              sizeof(double)); // sums over all rows from y + 1 down, columns from x + 1 on
    for (int y = grad_sum->height - 1; y >= 0; y--) {
        const double *row = grad_sum->sum + (size_t)(y + 1) * stride;
        double run[3] = {0, 0, 0};
        for (size_t x = width; x-- > 0;) {
            for (size_t c = 0; c < 3; c++) {
                run[c] += row[N * (x + 1) + c];
                below[3 * x + c] += run[c];
                grad_pattern->data[((size_t)y * width + x) * 3 + c] = (real)below[3 * x + c];
            }
        }
    }
    ffp_free(below);
}
