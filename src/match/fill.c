#include "match/fill.h"

#include <stdlib.h>

#include "base/arena.h"

#define ITERATIONS 80
#define OVER 1.85F // over-relaxation; holes are some tens of pixels wide

// Sum of the known values among the four neighbours; `known` false where 0 stands.
static int neighbours(const real *depth, int width, int height, int x, int y, real *sum) {
    const size_t i = (size_t)y * (size_t)width + (size_t)x;
    int count = 0;
    *sum = 0;
    if (x > 0 && depth[i - 1] > 0) *sum += depth[i - 1], count++;
    if (x + 1 < width && depth[i + 1] > 0) *sum += depth[i + 1], count++;
    if (y > 0 && depth[i - (size_t)width] > 0) *sum += depth[i - (size_t)width], count++;
    if (y + 1 < height && depth[i + (size_t)width] > 0) *sum += depth[i + (size_t)width], count++;
    return count;
}

// Grows the known region by a ring at a time; lists the pixels that it gained, in the order of their rings.
static size_t grow(real *depth, const real *mask, int width, int height, size_t *gained) {
    const size_t pixels = (size_t)width * (size_t)height;
    real *value = ffp_alloc(pixels, sizeof(real));
    size_t total = 0, start;
    do {
        start = total;
        for (size_t i = 0; i < pixels; i++) {
            real sum;
            if (depth[i] > 0 || (mask != NULL && mask[i] <= 0)) continue;
            const int count =
                neighbours(depth, width, height, (int)(i % (size_t)width), (int)(i / (size_t)width), &sum);
            if (count > 0) gained[total] = i, value[total++] = sum / (real)count;
        }
        for (size_t k = start; k < total; k++) depth[gained[k]] = value[k];
    } while (total > start);
    free(value);
    return total;
}

void ffp_fill_smoothly(real *depth, const real *mask, int width, int height) {
    size_t *gained = ffp_alloc((size_t)width * (size_t)height, sizeof *gained);
    const size_t total = grow(depth, mask, width, height, gained);
    for (int round = 0; round < ITERATIONS; round++) {
        for (size_t k = 0; k < total; k++) {
            const size_t i = gained[k];
            real sum;
            const int count =
                neighbours(depth, width, height, (int)(i % (size_t)width), (int)(i / (size_t)width), &sum);
            if (count == 0) continue;
            const real moved = depth[i] + OVER * (sum / (real)count - depth[i]);
            depth[i] = moved > 0 ? moved : sum / (real)count;
        }
    }
    free(gained);
}
