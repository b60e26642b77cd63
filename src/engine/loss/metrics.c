// Peak signal-to-noise ratio, over a whole picture or its foreground.
#include "engine/loss/metrics.h"
#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include "core/base/arena.h"
#include "core/base/device.h"
#include "engine/loss/deferred.h"
#include "engine/loss/rows.h"
#include "engine/loss/table.h"

typedef struct Pictures {
    const FfpImage *a, *b, *mask; // mask may be NULL: every pixel counts
    size_t *counts;               // [height] of values, with a mask
} Pictures;

static double squared_numbers(const real *a, const real *b, size_t count) {
    double sum = 0;
#pragma omp simd reduction(+ : sum)
    for (size_t i = 0; i < count; i++) {
        const double difference = (double)a[i] - (double)b[i];
        sum += difference * difference;
    }
    return sum;
}

static double squared_row(const void *argument, int y) {
    const Pictures *p = argument;
    const size_t width = (size_t)p->a->width, channels = (size_t)p->a->channels, first = (size_t)y * width;
    const real *a = p->a->data + first * channels, *b = p->b->data + first * channels;
    double sum = 0;
    if (!p->mask) return squared_numbers(a, b, width * channels);
    p->counts[y] = 0;
    for (size_t i = 0; i < width; i++) {
        if (!(p->mask->data[first + i] > 0.5F)) continue;
        sum += squared_numbers(a + i * channels, b + i * channels, channels);
        p->counts[y] += channels;
    }
    return sum;
}

static double squared_error(const FfpImage *a, const FfpImage *b, const FfpImage *mask, size_t *count) {
    const size_t height = (size_t)a->height;
    const Pictures pictures = {a, b, mask, mask ? ffp_take(height, sizeof *pictures.counts) : NULL};
    const double sum = ffp_sum_of_rows(a->height, squared_row, &pictures);
    *count = mask ? 0 : height * (size_t)a->width * (size_t)a->channels;
    for (size_t y = 0; mask && y < height; y++) *count += pictures.counts[y];
    ffp_free(pictures.counts);
    return sum;
}

static double psnr(const FfpImage *a, const FfpImage *b, const FfpImage *mask) {
    assert(a->width == b->width && a->height == b->height && a->channels == b->channels);
    assert(!mask || (mask->width == a->width && mask->height == a->height && mask->channels == 1));
    size_t count;
    const double sum = ffp_device() ? ffp_device()->loss->squared_error(a, b, mask, &count)
                                    : squared_error(a, b, mask, &count);
    if (!mask && ffp_loss_deferred_as(FFP_DEFERRED_PSNR, 1)) return 0;
    if (count == 0) return NAN;
    return ffp_psnr_of(sum / (double)count);
}

double ffp_psnr(const FfpImage *a, const FfpImage *b) {
    return psnr(a, b, NULL);
}

double ffp_psnr_masked(const FfpImage *a, const FfpImage *b, const FfpImage *mask) {
    return psnr(a, b, mask);
}
