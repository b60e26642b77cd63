#include "engine/apply/unseen.h"
#include <string.h>
#include <tgmath.h>
#include "engine/apply/surface.h"

#define REACH_SHARE 20 // the longer side is so many times as long as the light that goes on
#define TRUSTED 2      // times the known share of a mean is the weight that it has over coarser ones
enum { LEVELS_MAX = 16 };

// Levels that are known, and 1, or 0.
static FfpImage known_of(const FfpImage *levels) {
    FfpImage out = ffp_image_new(levels->width, levels->height, 4);
    const ptrdiff_t pixels = (ptrdiff_t)levels->width * levels->height;
    for (ptrdiff_t p = 0; p < pixels; p++) {
        const real *from = levels->data + 4 * p;
        real *to = out.data + 4 * p;
        if (!(from[3] > 0)) continue;
        for (int c = 0; c < 4; c++) to[c] = from[c] / from[3];
    }
    return out;
}

static FfpImage halved(const FfpImage *image) {
    const int width = image->width > 1 ? image->width / 2 : 1,
              height = image->height > 1 ? image->height / 2 : 1;
    const int right = image->width > 1, below = image->height > 1 ? image->width : 0;
    FfpImage out = ffp_image_new(width, height, 4);
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            const size_t first =
                (size_t)(image->height > 1 ? 2 * y : 0) * (size_t)image->width + (size_t)(right ? 2 * x : 0);
            const size_t four[4] = {first, first + (size_t)right, first + (size_t)below,
                                    first + (size_t)right + (size_t)below};
            real *to = out.data + 4 * ((size_t)y * (size_t)width + (size_t)x);
            for (int k = 0; k < 4; k++)
                for (int c = 0; c < 4; c++) to[c] += image->data[4 * four[k] + (size_t)c] / 4;
        }
    return out;
}

// The level at a place, shares of the sides: coarse means wherever finer ones are not known.
static void pull(const FfpImage *means, int n, real u, real v, real level[3]) {
    memset(level, 0, 3 * sizeof *level);
    for (int k = n - 1; k > 0; k--) {
        real mean[4];
        ffp_image_sample(&means[k], u * (real)means[k].width, v * (real)means[k].height, mean);
        if (!(mean[3] > 0)) continue;
        const real weight = fmin(TRUSTED * mean[3], (real)1);
        for (int c = 0; c < 3; c++) level[c] += weight * (mean[c] / mean[3] - level[c]);
    }
}

void ffp_fill_unseen(FfpImage *levels, const FfpImage *lit) {
    const int width = levels->width, height = levels->height, longer = width > height ? width : height;
    const real reach = fmax((real)longer / REACH_SHARE, (real)1);
    FfpImage means[LEVELS_MAX] = {known_of(levels)}, away = ffp_image_new(width, height, 1);
    int n = 1;
    for (; n < LEVELS_MAX && (means[n - 1].width > 1 || means[n - 1].height > 1); n++)
        means[n] = halved(&means[n - 1]);
    for (int p = 0; p < width * height; p++) away.data[p] = levels->data[4 * p + 3] > 0 ? 0 : INFINITY;
    ffp_distances(&away);
#pragma omp parallel for schedule(static)
    for (int p = 0; p < width * height; p++) {
        const real near = 1 - away.data[p] / reach;
        real *level = levels->data + 4 * (ptrdiff_t)p;
        if (level[3] > 0 || !(lit->data[p] > 0) || !(near > 0)) continue;
        pull(means, n, ((real)(p % width) + 0.5F) / (real)width, ((real)(p / width) + 0.5F) / (real)height,
             level);
        for (int c = 0; c < 3; c++) level[c] *= near * near * (3 - 2 * near);
        level[3] = 1;
    }
    for (int k = 0; k < n; k++) ffp_image_free(&means[k]);
    ffp_image_free(&away);
}
