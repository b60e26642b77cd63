// Blurs and the index of structural similarity (engine/loss/ssim.c).
#include <omp.h>
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "engine/loss/kernels/kernels.h"
#include "engine/loss/terms.h"

enum { MOMENTS = FFP_SSIM_MOMENTS, SLOPES = FFP_SSIM_SLOPES };
enum { SLOPE_A, SLOPE_AA, SLOPE_AB };

// sum_k taps[k] rows[k][i]: all taps of a number in one go, so that the sum is written once.
static void blur(const FfpSsimWindow *window, real *restrict out, const real *restrict taps,
                 const real *const rows[FFP_SSIM_TAPS]) {
    const real *row[FFP_SSIM_TAPS];
    for (int k = 0; k < FFP_SSIM_TAPS; k++) row[k] = rows[k];
    for (int i = 0; i < window->row; i++) {
        real sum = 0;
        FFP_UNROLL(11)
        for (int k = 0; k < FFP_SSIM_TAPS; k++) sum += taps[k] * row[k][i];
        out[i] = sum;
    }
}

// Along a row of interleaved channels; `padded` has `edge` zeros on either side.
static void blur_across(const FfpSsimWindow *window, real *restrict out, const real *restrict padded) {
    const real *rows[FFP_SSIM_TAPS];
    for (int k = 0; k < FFP_SSIM_TAPS; k++) rows[k] = padded + (size_t)k * window->channels;
    blur(window, out, window->taps, rows);
}

// Row y of `map` blurred down the columns.
static void blur_down(const FfpSsimWindow *window, real *restrict out, const real *restrict map, int y) {
    const real *rows[FFP_SSIM_TAPS];
    real taps[FFP_SSIM_TAPS];
    for (int k = 0; k < FFP_SSIM_TAPS; k++) {
        const int from = y + k - FFP_SSIM_RADIUS;
        const bool inside = from >= 0 && from < window->height;
        taps[k] = inside ? window->taps[k] : 0;
        rows[k] = map + (size_t)(inside ? from : y) * window->row;
    }
    blur(window, out, taps, rows);
}

void FFP_K(ssim_moments)(const FfpSsimWindow *window, real *moments, const FfpImage *a, const FfpImage *b) {
    const size_t row = window->row;
    const size_t size = row + 2 * (size_t)window->edge;
    real *all = ffp_alloc((size_t)omp_get_max_threads() * size, sizeof *all);
#pragma omp parallel
    {
        real *padded = all + (size_t)omp_get_thread_num() * size, *middle = padded + window->edge;
#pragma omp for schedule(static)
        for (int y = 0; y < window->height; y++) {
            const real *ra = a->data + y * row, *rb = b->data + y * row;
            const real *left[MOMENTS] = {ra, rb, ra, rb, ra}, *right[MOMENTS] = {NULL, NULL, ra, rb, rb};
            for (int m = 0; m < MOMENTS; m++) {
                for (size_t i = 0; i < row; i++) middle[i] = right[m] ? left[m][i] * right[m][i] : left[m][i];
                blur_across(window, moments + ((size_t)m * window->height + y) * row, padded);
            }
        }
    }
    ffp_free(all);
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

void FFP_K(ssim_compare)(const FfpSsimWindow *window, double *row_sums, real *slopes, const real *moments) {
    const size_t row = window->row, padded = row + 2 * (size_t)window->edge;
    const size_t size = MOMENTS * row + SLOPES * padded;
    real *all = ffp_alloc((size_t)omp_get_max_threads() * size, sizeof *all);
#pragma omp parallel
    {
        real *scratch = all + (size_t)omp_get_thread_num() * size;
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
    }
    ffp_free(all);
}

void FFP_K(ssim_gradient)(const FfpSsimWindow *window, const real *slopes, const FfpImage *a,
                          const FfpImage *b, real scale, FfpImage *grad) {
    const size_t row = window->row;
    real *all = ffp_alloc((size_t)omp_get_max_threads() * SLOPES * row, sizeof *all);
#pragma omp parallel
    {
        real *slope = all + (size_t)omp_get_thread_num() * SLOPES * row;
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
    }
    ffp_free(all);
}
