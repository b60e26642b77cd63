#include "rig/masks/local_mean.h"
#include <string.h>
#include <tgmath.h>
#include "core/base/alloc.h"

#define RADIUS_MAX 64 // pixels of a Gaussian's half

typedef struct Kernel {
    int radius;
    real weights[2 * RADIUS_MAX + 1];
} Kernel;

static Kernel gaussian(double sigma) {
    Kernel k = {.radius = (int)fmin(ceil(3 * sigma), RADIUS_MAX)};
    double sum = 0;
    for (int i = -k.radius; i <= k.radius; i++) sum += exp(-0.5 * i * i / (sigma * sigma));
    for (int i = -k.radius; i <= k.radius; i++)
        k.weights[i + k.radius] = (real)(exp(-0.5 * i * i / (sigma * sigma)) / sum);
    return k;
}

static int held(int at, int n) {
    return at < 0 ? 0 : at >= n ? n - 1 : at;
}

static void add_row(real *restrict to, const real *restrict from, real weight, int count) {
    for (int i = 0; i < count; i++) to[i] += weight * from[i];
}

// A row moved by k pixels, its ends repeated.
static void add_moved(real *to, const real *from, real weight, int k, int w, int n) {
    const int first = held(-k, w + 1), last = held(w - k, w + 1);
    for (int x = 0; x < first; x++) add_row(to + (ptrdiff_t)x * n, from, weight, n);
    if (first < last)
        add_row(to + (ptrdiff_t)first * n, from + (ptrdiff_t)(first + k) * n, weight, (last - first) * n);
    for (int x = last > first ? last : first; x < w; x++)
        add_row(to + (ptrdiff_t)x * n, from + (ptrdiff_t)(w - 1) * n, weight, n);
}

// Along rows (down false) or columns. Whole rows at a time, so that pixels are added side by side.
static FfpImage pass(const FfpImage *image, const Kernel *kernel, bool down) {
    const int w = image->width, h = image->height, n = image->channels;
    FfpImage out = ffp_image_new(w, h, n);
#pragma omp parallel for schedule(static)
    for (int y = 0; y < h; y++)
        for (int k = -kernel->radius; k <= kernel->radius; k++) {
            const real weight = kernel->weights[k + kernel->radius],
                       *from = image->data + (ptrdiff_t)(down ? held(y + k, h) : y) * w * n;
            add_moved(out.data + (ptrdiff_t)y * w * n, from, weight, down ? 0 : k, w, n);
        }
    return out;
}

FfpImage ffp_local_mean(const FfpImage *image, double sigma) {
    const Kernel kernel = gaussian(sigma);
    FfpImage across = pass(image, &kernel, false), out = pass(&across, &kernel, true);
    ffp_image_free(&across);
    return out;
}

FfpImage ffp_local_mean_where(const FfpImage *image, const unsigned char *where, double sigma) {
    const ptrdiff_t pixels = (ptrdiff_t)image->width * image->height;
    const int n = image->channels;
    FfpImage weighted = ffp_image_new(image->width, image->height, n + 1);
    for (ptrdiff_t i = 0; i < pixels; i++) {
        if (!where[i]) continue;
        for (int c = 0; c < n; c++) weighted.data[i * (n + 1) + c] = image->data[i * n + c];
        weighted.data[i * (n + 1) + n] = 1;
    }
    FfpImage out = ffp_local_mean(&weighted, sigma);
    ffp_image_free(&weighted);
    for (ptrdiff_t i = 0; i < pixels; i++) {
        real *p = out.data + i * (n + 1);
        for (int c = 0; c < n; c++) p[c] = p[n] > 0 ? p[c] / p[n] : 0;
    }
    return out;
}

// One step in the four directions for marks of one value.
static void step(unsigned char *marks, unsigned char *before, int width, int height, unsigned char value) {
    memcpy(before, marks, (size_t)width * (size_t)height);
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            const ptrdiff_t at = (ptrdiff_t)y * width + x;
            if ((x > 0 && before[at - 1] == value) || (x + 1 < width && before[at + 1] == value) ||
                (y > 0 && before[at - width] == value) || (y + 1 < height && before[at + width] == value))
                marks[at] = value;
        }
}

static void steps_of(unsigned char *marks, int width, int height, int steps, unsigned char value) {
    unsigned char *before = ffp_alloc((size_t)width * (size_t)height, 1);
    for (int i = 0; i < steps; i++) step(marks, before, width, height, value);
    ffp_free(before);
}

void ffp_marks_grow(unsigned char *marks, int width, int height, int steps) {
    steps_of(marks, width, height, steps, 1);
}

void ffp_marks_shrink(unsigned char *marks, int width, int height, int steps) {
    steps_of(marks, width, height, steps, 0);
}
