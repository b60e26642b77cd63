#include "engine/denoise/denoise.h"
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/call.h"
#include "core/base/integer.h"
#include "engine/denoise/kernels/kernels.h"
#include "engine/denoise/stack.h"

#define CLOSE 2 // pixels between windows,
#define WIDE 3  // and in pictures of more than MANY pixels: a pixel is in five windows instead of twelve
#define MANY 65536
#define STRIP 64   // rows of pixels for which windows are kept
#define DOUBT 1.5  // times the noise's variance is taken off a measured variance
#define TRUST 0.3  // of a window: 1 over this and the number of axes it keeps
#define ENOUGH 4.0 // pixels' worth of coverage that a window needs

typedef struct Range {
    int from, to; // pixels, the last one included
} Range;

static Range around(int centre, int size) {
    return (Range){centre < FFP_WINDOW_RADIUS ? 0 : centre - FFP_WINDOW_RADIUS,
                   centre + FFP_WINDOW_RADIUS >= size ? size - 1 : centre + FFP_WINDOW_RADIUS};
}

// Pictures are the object's colour times the coverage: the colour nearest to all pixels is a least-squares
// one. Returns the pixels' worth of coverage.
static double window_mean(const FfpFilter *f, Range x, Range y, double mean[FFP_VALUES]) {
    double total = 0;
    memset(mean, 0, FFP_VALUES * sizeof *mean);
    for (int row = y.from; row <= y.to; row++)
        for (int column = x.from; column <= x.to; column++) {
            const size_t i = (size_t)row * (size_t)f->width + (size_t)column;
            const double c = (double)f->coverage[i];
            total += c * c;
            for (int v = 0; v < FFP_VALUES; v++) mean[v] += c * (double)f->stack[i * FFP_VALUES + (size_t)v];
        }
    for (int v = 0; total > 0 && v < FFP_VALUES; v++) mean[v] /= total;
    return total;
}

static void window_covariance(const FfpFilter *f, Range x, Range y, const double mean[FFP_VALUES],
                              double a[FFP_VALUES * FFP_VALUES]) {
    int count = 0;
    memset(a, 0, FFP_VALUES * FFP_VALUES * sizeof *a);
    for (int row = y.from; row <= y.to; row++)
        for (int column = x.from; column <= x.to; column++) {
            const size_t i = (size_t)row * (size_t)f->width + (size_t)column;
            const double c = (double)f->coverage[i];
            double e[FFP_VALUES];
            if (c <= 0) continue;
            count++;
            for (int v = 0; v < FFP_VALUES; v++)
                e[v] = (double)f->stack[i * FFP_VALUES + (size_t)v] - c * mean[v];
            for (int p = 0; p < FFP_VALUES; p++)
                for (int q = 0; q <= p; q++) a[p * FFP_VALUES + q] += e[p] * e[q];
        }
    for (int i = 0; i < FFP_VALUES * FFP_VALUES; i++) a[i] /= count;
}

static void measure(const FfpFilter *f, int x, int y, FfpWindow *window) {
    double mean[FFP_VALUES], axes[FFP_VALUES * FFP_VALUES], variances[FFP_VALUES], kept = 0;
    const Range across = around(x, f->width), down = around(y, f->height);
    if (window_mean(f, across, down, mean) < ENOUGH) return;
    window_covariance(f, across, down, mean, axes);
    ffp_eigen(axes, FFP_VALUES, variances);
    for (int v = 0; v < FFP_VALUES; v++) window->mean[v] = (real)mean[v];
    for (int a = 0; a < FFP_VALUES; a++) {
        const double *axis = axes + a * FFP_VALUES;
        const double signal = fmax(variances[a] - DOUBT * f->variance, 0);
        const double share = signal / (signal + f->variance);
        kept += share;
        for (int p = 0; share > 0 && p < FFP_VALUES; p++)
            for (int q = 0; q < FFP_VALUES; q++)
                window->kept[p * FFP_VALUES + q] += (real)(share * axis[p] * axis[q]);
    }
    window->weight = (real)(1 / (TRUST + kept));
}

// The windows that hold pixels of rows from `top` up to, not including, `bottom`.
static void measure_strip(FfpFilter *f, int top, int bottom) {
    f->first = ffp_first_window(f, top);
    f->rows = ffp_smaller((bottom - 1 + FFP_WINDOW_RADIUS) / f->stride + 1, f->down) - f->first;
    memset(f->windows, 0, (size_t)f->rows * (size_t)f->across * sizeof *f->windows);
#pragma omp parallel for schedule(dynamic)
    for (int row = 0; row < f->rows; row++)
        for (int column = 0; column < f->across; column++)
            measure(f, column * f->stride, (f->first + row) * f->stride,
                    &f->windows[(size_t)row * (size_t)f->across + (size_t)column]);
}

static void smooth_strip(const FfpFilter *f, int top, int bottom, FfpImage *pictures[FFP_PHOTOGRAPHS]) {
    FfpSmooth *smooth = ffp_denoise_kernels()->smooth;
#pragma omp parallel for schedule(dynamic)
    for (int y = top; y < bottom; y++)
        for (int x = 0; x < f->width; x++) {
            const size_t i = (size_t)y * (size_t)f->width + (size_t)x;
            real values[FFP_VALUES];
            if (f->coverage[i] <= 0) continue;
            smooth(f, x, y, values);
            for (int p = 0; p < FFP_PHOTOGRAPHS; p++)
                if (pictures[p]) memcpy(pictures[p]->data + 3 * i, values + 3 * p, 3 * sizeof *values);
        }
}

// Takes the noise away in pictures that are copies of the view's; NULL: not wanted.
static void denoise_view(const FfpView *view, const int photographs[FFP_PHOTOGRAPHS], double noise,
                         FfpImage *pictures[FFP_PHOTOGRAPHS]) {
    real *stack = ffp_stack_new(view, photographs);
    const int width = view->camera.width, height = view->camera.height,
              stride = (int64_t)width * height > MANY ? WIDE : CLOSE;
    FfpFilter f = {.width = width,
                   .height = height,
                   .stride = stride,
                   .across = (width + stride - 1) / stride,
                   .down = (height + stride - 1) / stride,
                   .variance = noise * noise,
                   .stack = stack,
                   .coverage = view->coverage.data};
    f.windows =
        ffp_alloc((size_t)f.across * ((STRIP + 2 * FFP_WINDOW_RADIUS) / stride + 2), sizeof *f.windows);
    for (int top = 0; top < f.height; top += STRIP) {
        const int bottom = ffp_smaller(top + STRIP, f.height);
        ffp_cancel_point();
        measure_strip(&f, top, bottom);
        smooth_strip(&f, top, bottom, pictures);
    }
    ffp_free(f.windows);
    ffp_free(stack);
}

FfpImage *ffp_denoise(FfpCapture *capture, const int *photographs, int n, double noise) {
    const size_t length = (size_t)capture->n_patterns;
    FfpImage *lists = ffp_alloc((size_t)capture->n_views * length, sizeof *lists);
    for (int v = 0; v < capture->n_views; v++) {
        FfpView *view = &capture->views[v];
        FfpImage *list = lists + (size_t)v * length;
        if (!ffp_has_photographs(view, photographs)) continue;
        memcpy(list, view->images, length * sizeof *list);
        for (int p = 0; p < n; p++) list[photographs[p]] = ffp_image_copy(&view->images[photographs[p]]);
        for (int p = FFP_PHOTOGRAPHS - 1; p < n; p++) {
            if (!list[photographs[p]].data) continue;
            const int together[FFP_PHOTOGRAPHS] = {photographs[0], photographs[1], photographs[p]};
            const bool first = p == FFP_PHOTOGRAPHS - 1;
            FfpImage *pictures[FFP_PHOTOGRAPHS] = {first ? &list[together[0]] : NULL,
                                                   first ? &list[together[1]] : NULL, &list[together[2]]};
            denoise_view(view, together, noise, pictures);
        }
        view->images = list;
    }
    return lists;
}

void ffp_denoise_free(FfpImage *lists, const FfpCapture *capture, const int *photographs, int n) {
    if (!lists) return;
    for (int v = 0; v < capture->n_views; v++)
        for (int p = 0; p < n; p++)
            ffp_image_free(&lists[(size_t)v * (size_t)capture->n_patterns + (size_t)photographs[p]]);
    ffp_free(lists);
}
