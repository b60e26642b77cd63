#include "engine/render/outline.h"
#include <stdlib.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "core/base/vec.h"
#include "engine/render/resolve_pixel.h"

enum { LOOKED_AT = 4096, CHANNELS = 4 };  // splats whose median counts; light, and how much is covered
#define SMOOTHED (2 / 3.0F)               // of the median splat's deviation
#define LEAST 0.4F                        // pixels; at the photographs' own size it is 0.22 to 0.3
#define MOST ((real)FFP_STRIP_MARGIN / 2) // two deviations around a pixel are looked at
#define WHOLE 0.99F

static int by_size(const void *a, const void *b) {
    const real x = *(const real *)a, y = *(const real *)b;
    return (x > y) - (x < y);
}

// The middle one of three deviations: the shorter across a flat splat.
static real middle(const real s[3]) {
    return fmax(fmin(s[0], s[1]), fmin(fmax(s[0], s[1]), s[2]));
}

real ffp_outline_deviation(const FfpGaussians *g, const FfpCamera *camera) {
    const int64_t step = g->count / LOOKED_AT + 1;
    const real *pose = camera->pose, eye[3] = {pose[3], pose[7], pose[11]},
               axis[3] = {pose[2], pose[6], pose[10]};
    real *sizes = ffp_alloc(LOOKED_AT, sizeof *sizes);
    int count = 0;
    for (int64_t i = 0; i < g->count; i += step) {
        const real *c = g->centre + 3 * i, away[3] = {c[0] - eye[0], c[1] - eye[1], c[2] - eye[2]};
        const real z = ffp_dot3(away, axis);
        if (z > 0) sizes[count++] = middle(g->scale + 3 * i) * camera->fx / z;
    }
    qsort(sizes, (size_t)count, sizeof *sizes, by_size);
    const real deviation = count ? SMOOTHED * sizes[count / 2] : 0;
    ffp_free(sizes);
    return deviation < LEAST ? 0 : fmin(deviation, MOST);
}

typedef struct Smoothing {
    int reach;
    real weight[FFP_STRIP_MARGIN + 1]; // of the pixel itself and on either side
    real steepness;
} Smoothing;

static Smoothing smoothing_of(real deviation) {
    Smoothing s = {.reach = (int)ceil(2 * deviation)};
    real sum = 0;
    for (int i = 0; i <= s.reach; i++) {
        s.weight[i] = exp(-(real)(i * i) / (2 * deviation * deviation));
        sum += (i ? 2 : 1) * s.weight[i];
    }
    for (int i = 0; i <= s.reach; i++) s.weight[i] /= sum;
    // a pixel is a box, of variance 1/12; where a step was smoothed by both, its slope is 1 / this
    s.steepness = sqrt(2 * FFP_PI * (deviation * deviation + 1 / 12.0F));
    return s;
}

static inline int held(int i, int size) {
    return i < 0 ? 0 : i < size ? i : size - 1;
}

// Row y, across.
static void smooth_across(const Smoothing *s, const FfpImage *mean, const real *opacity, int y, real *out) {
    const ptrdiff_t row = (ptrdiff_t)y * mean->width;
    for (int x = 0; x < mean->width; x++) {
        real sum[CHANNELS] = {0};
        for (int i = -s->reach; i <= s->reach; i++) {
            const ptrdiff_t p = row + held(x + i, mean->width);
            const real weight = s->weight[abs(i)];
            for (int k = 0; k < 3; k++) sum[k] += weight * mean->data[3 * p + k];
            sum[3] += weight * opacity[p];
        }
        for (int k = 0; k < CHANNELS; k++) out[CHANNELS * x + k] = sum[k];
    }
}

// And down: pixel (x, y).
static void smooth_down(const Smoothing *s, const real *across, int x, int y, int width, int height,
                        real sum[CHANNELS]) {
    for (int k = 0; k < CHANNELS; k++) sum[k] = 0;
    for (int i = -s->reach; i <= s->reach; i++) {
        const real *from = across + CHANNELS * ((ptrdiff_t)held(y + i, height) * width + x);
        for (int k = 0; k < CHANNELS; k++) sum[k] += s->weight[abs(i)] * from[k];
    }
}

static void resolve_one(const real mean[3], real opacity, const real around[CHANNELS], int side,
                        real steepness, real picture[3]) {
    const real near = around[3];
    if ((opacity >= WHOLE && near >= WHOLE) || near < FFP_OPACITY_MIN) {
        ffp_resolve_pixel(mean, opacity, side, picture);
        return;
    }
    const real covered = fmin(fmax(0.5F + steepness * (near - 0.5F), 0), 1);
    const real missing = fmax(1 - opacity, 0) / near;
    for (int k = 0; k < 3; k++) picture[k] = covered * ffp_srgb_encode(mean[k] + missing * around[k]);
}

void ffp_resolve_smoothly(const FfpImage *mean, const real *opacity, int side, real deviation,
                          FfpImage *picture) {
    const int width = mean->width, height = mean->height;
    const Smoothing s = smoothing_of(deviation);
    const size_t row = (size_t)CHANNELS * (size_t)width;
    real *across = ffp_alloc(row * (size_t)height, sizeof *across);
#pragma omp parallel for schedule(static)
    for (int y = 0; y < height; y++) smooth_across(&s, mean, opacity, y, across + row * (size_t)y);
#pragma omp parallel for schedule(static)
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            const ptrdiff_t p = (ptrdiff_t)y * width + x;
            real around[CHANNELS];
            smooth_down(&s, across, x, y, width, height, around);
            resolve_one(mean->data + 3 * p, opacity[p], around, side, s.steepness, picture->data + 3 * p);
        }
    ffp_free(across);
}
