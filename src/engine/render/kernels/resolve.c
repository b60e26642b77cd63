// Means of samples, and back (resolve.h).
#include <string.h>
#include "engine/render/kernels/kernels.h"
#include "engine/render/resolve_pixel.h"

enum { PART = 128 }; // pixels of a row at a time: what they add up to stays in the nearest cache

// `count` pixels of 2 x 2 samples, from the sums of their two rows: 2 count channels of them, all set, which
// the analyzer does not follow through the product.
static inline void average_pairs(const real *restrict sums, int count, const int channels,
                                 real *restrict out) {
    for (int x = 0; x < count; x++)
        for (int k = 0; k < channels; k++)
            // NOLINTNEXTLINE(clang-analyzer-core.UndefinedBinaryOperatorResult)
            out[x * channels + k] = 0.25F * (sums[2 * x * channels + k] + sums[(2 * x + 1) * channels + k]);
}

static void average_twos(const real *samples, int width, int channels, real *out) {
    const real *below = samples + (ptrdiff_t)2 * width * channels;
    real sums[2 * PART * 3];
    for (int x = 0; x < width; x += PART) {
        const int count = width - x < PART ? width - x : PART;
        const real *upper = samples + 2 * x * channels, *lower = below + 2 * x * channels;
        for (int i = 0; i < 2 * count * channels; i++) sums[i] = upper[i] + lower[i];
        if (channels == 3)
            average_pairs(sums, count, 3, out + 3 * x);
        else
            average_pairs(sums, count, 1, out + x);
    }
}

void FFP_K(average_row)(const real *samples, int width, int channels, int side, real *out) {
    if (side == 2 && (channels == 1 || channels == 3)) {
        average_twos(samples, width, channels, out);
        return;
    }
    const ptrdiff_t stride = (ptrdiff_t)width * side * channels;
    for (int x = 0; x < width; x++)
        for (int k = 0; k < channels; k++)
            out[x * channels + k] =
                ffp_sample_mean(samples + x * side * channels + k, stride, channels, side);
}

// Each pixel's gradient to every sample of its row.
static inline void spread_row(const real *restrict grad, int width, const int channels, const int side,
                              real *restrict samples) {
    const real share = 1 / (real)(side * side);
    for (int x = 0; x < width; x++)
        for (int u = 0; u < side; u++)
            for (int k = 0; k < channels; k++)
                samples[(x * side + u) * channels + k] = share * grad[x * channels + k];
}

void FFP_K(average_row_backward)(const real *grad, int width, int channels, int side, real *samples) {
    const ptrdiff_t stride = (ptrdiff_t)width * side * channels;
    if (side == 2 && channels == 1)
        spread_row(grad, width, 1, 2, samples);
    else if (side == 2 && channels == 3)
        spread_row(grad, width, 3, 2, samples);
    else
        spread_row(grad, width, channels, side, samples);
    for (int v = 1; v < side; v++) memcpy(samples + v * stride, samples, (size_t)stride * sizeof *samples);
}

__attribute__((flatten)) void FFP_K(resolve_row)(const real *mean, const real *opacity, int count, int side,
                                                 real *picture) {
#pragma GCC ivdep
    for (int p = 0; p < count; p++) ffp_resolve_pixel(mean + 3 * p, opacity[p], side, picture + 3 * p);
}

__attribute__((flatten)) void FFP_K(resolve_row_backward)(const real *mean, const real *opacity, int count,
                                                          int side, const real *grad_picture, real *grad_mean,
                                                          real *grad_opacity) {
#pragma GCC ivdep
    for (int p = 0; p < count; p++)
        ffp_resolve_pixel_backward(mean + 3 * p, opacity[p], side, grad_picture + 3 * p, grad_mean + 3 * p,
                                   &grad_opacity[p]);
}
