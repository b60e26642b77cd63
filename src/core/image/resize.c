// Resizing, one axis after the other: area averages when an axis shrinks, linear interpolation when it grows.
#include <omp.h>
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "core/image/image.h"

// An output pixel's share of the input: `count` pixels from `first` on, with weights that sum to 1.
typedef struct Taps {
    int most; // room for weights per output pixel
    int *first, *count;
    real *weights; // [n_out, most]
} Taps;

static Taps taps_new(int n_in, int n_out) {
    const double step = (double)n_in / n_out; // input pixels per output pixel
    Taps taps = {.most = (step > 1 ? (int)step + 2 : 2)};
    taps.first = ffp_alloc((size_t)n_out, sizeof(int));
    taps.count = ffp_alloc((size_t)n_out, sizeof(int));
    taps.weights = ffp_alloc((size_t)n_out * (size_t)taps.most, sizeof(real));
    for (int i = 0; i < n_out; i++) {
        real *weights = taps.weights + (size_t)i * (size_t)taps.most;
        if (step > 1) {
            const double low = i * step, high = fmin((i + 1) * step, (double)n_in);
            taps.first[i] = (int)low;
            for (int x = (int)low; x < n_in && (double)x < high && taps.count[i] < taps.most; x++) {
                weights[taps.count[i]++] =
                    (real)((fmin(high, x + 1.0) - fmax(low, (double)x)) / (high - low));
            }
        } else {
            const double x = fmin(fmax((i + 0.5) * step - 0.5, 0), n_in - 1.0);
            taps.first[i] = (int)x;
            taps.count[i] = (int)x + 1 < n_in ? 2 : 1;
            weights[0] = taps.count[i] == 2 ? (real)(1 - (x - (int)x)) : 1;
            weights[1] = (real)(x - (int)x);
        }
    }
    return taps;
}

static void taps_free(Taps *taps) {
    ffp_free(taps->first);
    ffp_free(taps->count);
    ffp_free(taps->weights);
}

static inline void narrow_channels(const Taps *across, const real *row, const int n, int width, real *to) {
    for (int x = 0; x < width; x++, to += n) {
        const real *from = row + (size_t)across->first[x] * (size_t)n;
        const real *weights = across->weights + (size_t)x * (size_t)across->most;
        for (int k = 0; k < across->count[x]; k++)
            for (int c = 0; c < n; c++) to[c] += weights[k] * from[k * n + c];
    }
}

static void narrow_row(const Taps *across, const real *row, int n, int width, real *to) {
    if (n == 3)
        narrow_channels(across, row, 3, width, to);
    else
        narrow_channels(across, row, n, width, to);
}

FfpImage ffp_image_resize_rows(const FfpRows *rows, int width, int height) {
    const int n = rows->channels;
    Taps across = taps_new(rows->width, width), down = taps_new(rows->height, height);
    FfpImage narrow = ffp_image_new(width, rows->height, n), out = ffp_image_new(width, height, n);
    const size_t row_in = (size_t)rows->width * (size_t)n;
    real *made = ffp_alloc((size_t)omp_get_max_threads(), row_in * sizeof *made);
#pragma omp parallel for schedule(static)
    for (int y = 0; y < rows->height; y++) {
        real *own = made + (size_t)omp_get_thread_num() * row_in;
        rows->make(rows->context, y, own);
        narrow_row(&across, own, n, width, narrow.data + (size_t)y * (size_t)width * (size_t)n);
    }
    ffp_free(made);
    const size_t row = (size_t)width * (size_t)n;
#pragma omp parallel for schedule(static)
    for (int y = 0; y < height; y++) {
        for (int k = 0; k < down.count[y]; k++) {
            const real weight = down.weights[(size_t)y * (size_t)down.most + (size_t)k];
            const real *from = narrow.data + (size_t)(down.first[y] + k) * row;
            real *to = out.data + (size_t)y * row;
            for (size_t i = 0; i < row; i++) to[i] += weight * from[i];
        }
    }
    ffp_image_free(&narrow);
    taps_free(&across);
    taps_free(&down);
    return out;
}

static void row_of(void *context, int y, real *row) {
    const FfpImage *image = context;
    const size_t count = (size_t)image->width * (size_t)image->channels;
    memcpy(row, image->data + (size_t)y * count, count * sizeof *row);
}

FfpImage ffp_image_resize(const FfpImage *image, int width, int height) {
    FfpImage from = *image;
    const FfpRows rows = {image->width, image->height, image->channels, row_of, &from};
    return ffp_image_resize_rows(&rows, width, height);
}
