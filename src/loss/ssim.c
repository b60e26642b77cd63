// Structural similarity (Wang, Bovik, Sheikh, Simoncelli 2004) with an 11x11 Gaussian window, sigma 1.5, and
// zero padding at the borders, as GS-ProCams takes it. The window is separable, and symmetric, hence its own
// adjoint: the gradient is the same blur applied to the slopes of the index with respect to the five local
// moments E[a], E[b], E[a a], E[b b], E[a b].
#include "loss/loss.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>
#include "base/arena.h"
#include "base/device.h"
#include "loss/late.h"
#include "loss/table.h"
#include "loss/terms.h"

enum { RADIUS = 5, TAPS = 2 * RADIUS + 1 };
enum { MOMENT_A, MOMENT_B, MOMENT_AA, MOMENT_BB, MOMENT_AB, MOMENTS };
enum { SLOPE_A, SLOPE_AA, SLOPE_AB, SLOPES };

typedef struct Window {
    int height, edge; // edge: values of padding on each side of a row
    int row;          // values in a row: width * channels
    int channels;
    real taps[TAPS];
} Window;

static Window window_for(const FfpImage *image) {
    Window window = {.height = image->height,
                     .edge = RADIUS * image->channels,
                     .row = image->width * image->channels,
                     .channels = image->channels};
    real sum = 0;
    for (int k = 0; k < TAPS; k++) {
        const real x = (real)(k - RADIUS) / 1.5F;
        sum += window.taps[k] = exp(-0.5F * x * x);
    }
    for (int k = 0; k < TAPS; k++) window.taps[k] /= sum;
    return window;
}

// Along a row of interleaved channels; `padded` has `edge` zeros on either side.
static void blur_across(const Window *window, real *restrict out, const real *restrict padded) {
    memset(out, 0, window->row * sizeof *out);
    for (int k = 0; k < TAPS; k++) {
        const real tap = window->taps[k], *from = padded + (size_t)k * window->channels;
        for (int i = 0; i < window->row; i++) out[i] += tap * from[i];
    }
}

// Row y of `map` blurred down the columns.
static void blur_down(const Window *window, real *restrict out, const real *restrict map, int y) {
    memset(out, 0, window->row * sizeof *out);
    for (int k = 0; k < TAPS; k++) {
        const int from = y + k - RADIUS;
        if (from < 0 || from >= window->height) continue;
        const real tap = window->taps[k], *row = map + (size_t)from * window->row;
        for (int i = 0; i < window->row; i++) out[i] += tap * row[i];
    }
}

// moments [MOMENTS, height, row]: the products a, b, aa, bb, ab, blurred along the rows only.
static void blur_moments(const Window *window, real *moments, const FfpImage *a, const FfpImage *b) {
    const size_t row = window->row;
#pragma omp parallel
    {
        real *padded = ffp_alloc(row + 2 * (size_t)window->edge, sizeof *padded);
        real *middle = padded + window->edge;
#pragma omp for schedule(static)
        for (int y = 0; y < window->height; y++) {
            const real *ra = a->data + y * row, *rb = b->data + y * row;
            const real *left[MOMENTS] = {ra, rb, ra, rb, ra}, *right[MOMENTS] = {NULL, NULL, ra, rb, rb};
            for (int m = 0; m < MOMENTS; m++) {
                for (size_t i = 0; i < row; i++) middle[i] = right[m] ? left[m][i] * right[m][i] : left[m][i];
                blur_across(window, moments + ((size_t)m * window->height + y) * row, padded);
            }
        }
        free(padded);
    }
}

// The index of one row from its moments, summed; slopes of the index by E[a], E[aa], E[ab].
static real compare_row(int count, const real *restrict moment, real *restrict slope_a,
                        real *restrict slope_aa, real *restrict slope_ab) {
    const real *ma = moment, *mb = ma + count, *maa = mb + count, *mbb = maa + count, *mab = mbb + count;
    real sum = 0;
#pragma omp simd reduction(+ : sum)
    for (int i = 0; i < count; i++)
        sum += ffp_ssim_term(ma[i], mb[i], maa[i], mbb[i], mab[i], &slope_a[i], &slope_aa[i], &slope_ab[i]);
    return sum;
}

// Sums of the index per row into row_sums [height]; slopes [SLOPES, height, row] blurred along the rows, or
// NULL.
static void compare(const Window *window, double *row_sums, real *slopes, const real *moments) {
    const size_t row = window->row, padded = row + 2 * (size_t)window->edge;
#pragma omp parallel
    {
        real *scratch = ffp_alloc(MOMENTS * row + SLOPES * padded, sizeof *scratch);
        real *slope[SLOPES];
        for (int s = 0; s < SLOPES; s++) slope[s] = scratch + MOMENTS * row + s * padded;
#pragma omp for schedule(static)
        for (int y = 0; y < window->height; y++) {
            for (int m = 0; m < MOMENTS; m++)
                blur_down(window, scratch + m * row, moments + m * row * window->height, y);
            row_sums[y] = compare_row(window->row, scratch, slope[SLOPE_A] + window->edge,
                                      slope[SLOPE_AA] + window->edge, slope[SLOPE_AB] + window->edge);
            for (int s = 0; slopes && s < SLOPES; s++)
                blur_across(window, slopes + ((size_t)s * window->height + y) * row, slope[s]);
        }
        free(scratch);
    }
}

// grad += scale (blur(slope_a) + 2 a blur(slope_aa) + b blur(slope_ab))
static void add_gradient(const Window *window, const real *slopes, const FfpImage *a, const FfpImage *b,
                         real scale, FfpImage *grad) {
    const size_t row = window->row;
#pragma omp parallel
    {
        real *slope = ffp_alloc(SLOPES * row, sizeof *slope);
#pragma omp for schedule(static)
        for (int y = 0; y < window->height; y++) {
            for (int s = 0; s < SLOPES; s++)
                blur_down(window, slope + s * row, slopes + s * row * window->height, y);
            const real *ra = a->data + y * row, *rb = b->data + y * row;
            real *g = grad->data + y * row;
#pragma omp simd
            for (size_t i = 0; i < row; i++)
                g[i] += scale * (slope[i] + 2 * ra[i] * slope[row + i] + rb[i] * slope[2 * row + i]);
        }
        free(slope);
    }
}

// Mean SSIM; adds scale * (gradient of the SUM of the index by a) to grad unless that is NULL.
static double mean_ssim(const FfpImage *a, const FfpImage *b, real scale, FfpImage *grad) {
    assert(a->width == b->width && a->height == b->height && a->channels == b->channels);
    const Window window = window_for(a);
    const size_t map = (size_t)window.row * window.height;
    if (map == 0) return 1;
    if (ffp_device()) return ffp_device()->loss->ssim(a, b, scale, grad);
    real *moments = ffp_alloc((MOMENTS + (grad ? SLOPES : 0)) * map, sizeof *moments);
    real *slopes = grad ? moments + MOMENTS * map : NULL;
    double *row_sums = ffp_alloc(window.height, sizeof *row_sums), sum = 0;
    blur_moments(&window, moments, a, b);
    compare(&window, row_sums, slopes, moments);
    for (int y = 0; y < window.height; y++) sum += row_sums[y];
    if (grad) add_gradient(&window, slopes, a, b, scale, grad);
    free(row_sums);
    free(moments);
    return sum / (double)map;
}

real ffp_ssim_loss(const FfpImage *prediction, const FfpImage *target, real weight, FfpImage *grad) {
    const real count = (real)prediction->width * prediction->height * prediction->channels;
    const double mean = mean_ssim(prediction, target, -weight / count, grad);
    return ffp_late_as(FFP_LATE_SIMILARITY, weight) ? 0 : weight * (real)(1 - mean);
}

real ffp_ssim(const FfpImage *a, const FfpImage *b) {
    return (real)mean_ssim(a, b, 0, NULL);
}
