// Squared difference to blurred patterns: the innermost loop of matching, one text for the CPU and the GPU.
#ifndef FFP_MATCH_BLURRED_H
#define FFP_MATCH_BLURRED_H

#include "engine/match/line.h"
#include "engine/match/observe.h"

// A cell, or what a pixel saw: three channels and a zero, one vector.
#ifdef __cplusplus // nvcc has no vectors of the C compiler's kind
struct alignas(16) FfpCell {
    float channel[4];
    __host__ __device__ float operator[](int c) const { return channel[c]; }
};
#define FFP_CELL_BY_CHANNEL(op)                                                                              \
    FFP_FORMULA FfpCell operator op(const FfpCell &a, const FfpCell &b) {                                    \
        return {a[0] op b[0], a[1] op b[1], a[2] op b[2], a[3] op b[3]};                                     \
    }
FFP_CELL_BY_CHANNEL(+)
FFP_CELL_BY_CHANNEL(-)
FFP_CELL_BY_CHANNEL(*)
FFP_FORMULA FfpCell operator*(float a, const FfpCell &b) {
    return {a * b[0], a * b[1], a * b[2], a * b[3]};
}
#else
typedef real FfpCell __attribute__((vector_size(4 * sizeof(real))));
#endif

typedef struct FfpObservedPixel {
    FfpCell ratio, weight;
    const FfpCell *cells; // of the pattern
} FfpObservedPixel;

// A pixel under the k-th of the patterns that it was seen under.
FFP_FORMULA FfpObservedPixel ffp_observed_pixel(const FfpObservation *observed, const FfpBlurred *patterns,
                                                int k, size_t pixel) {
    const size_t area = (size_t)observed->width * (size_t)observed->height;
    const real *r = observed->ratio + 3 * ((size_t)k * area + pixel), *w = observed->weight + 3 * pixel;
    return (FfpObservedPixel){{r[0], r[1], r[2], 0},
                              {w[0], w[1], w[2], 0},
                              (const FfpCell *)patterns->cells + (size_t)observed->asked[k] * patterns->area};
}

// Where FFP_MATCH_LANES positions lie on the grid.
typedef struct FfpCellPlaces {
    int first[FFP_MATCH_LANES]; // number of the upper left of four cells; -1 off the pattern
    real right[FFP_MATCH_LANES], low[FFP_MATCH_LANES]; // weights of the right two and of the lower two
} FfpCellPlaces;

FFP_FORMULA void ffp_find_cells(FfpCellPlaces *out, const FfpBlurred *blurred, const real u[FFP_MATCH_LANES],
                                const real v[FFP_MATCH_LANES]) {
#pragma omp simd
    for (int n = 0; n < FFP_MATCH_LANES; n++) {
        const real u0 = u[n] >= 0 ? u[n] : 0, v0 = v[n] >= 0 ? v[n] : 0;
        const real u1 = u0 <= blurred->width ? u0 : blurred->width,
                   v1 = v0 <= blurred->height ? v0 : blurred->height;
        const real x = u1 * blurred->scale + 0.5F, y = v1 * blurred->scale + 0.5F; // the border: one cell
        const int i = (int)x, j = (int)y, off = (u1 != u[n]) | (v1 != v[n]);
        out->right[n] = x - (real)i;
        out->low[n] = y - (real)j;
        out->first[n] = (j * blurred->stride + i) | -off;
    }
}

// weight (ratio - pattern)^2 of each channel at position n of the cells, which is on the pattern; bilinear.
FFP_FORMULA FfpCell ffp_blurred_cost(const FfpObservedPixel *observed, int stride, const FfpCellPlaces *cells,
                                     int n) {
    const FfpCell *p = observed->cells + cells->first[n], *q = p + stride;
    const FfpCell left = p[0] + cells->low[n] * (q[0] - p[0]), right = p[1] + cells->low[n] * (q[1] - p[1]);
    const FfpCell off = observed->ratio - (left + cells->right[n] * (right - left));
    return observed->weight * off * off;
}

FFP_FORMULA real ffp_sum_channels(FfpCell four) {
    return (four[0] + four[1]) + (four[2] + four[3]);
}

#endif
