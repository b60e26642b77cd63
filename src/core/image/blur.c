// Pictures through a Gaussian, and with a share of their light spread by one.
#include <math.h>
#include <omp.h>
#include <stdbool.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/image/image.h"

// A Gaussian's shares of the lines around one.
typedef struct Kernel {
    int radius;
    float *shares; // [2 radius + 1]
} Kernel;

// Sums of lines, `stride` values apart, each times its share: those from line `first` on. Beyond the lines 0
// to `last` the outermost ones are repeated.
static void sum_lines(float *sums, size_t values, const Kernel *kernel, const float *lines, size_t stride,
                      int first, int last) {
    memset(sums, 0, values * sizeof *sums);
    for (int k = 0; k <= 2 * kernel->radius; k++) {
        const int at = first + k < 0 ? 0 : first + k > last ? last : first + k;
        const float *line = lines + (size_t)at * stride, share = kernel->shares[k];
        for (size_t i = 0; i < values; i++) sums[i] += share * line[i];
    }
}

// A row with its ends repeated, so that one shifted by a pixel is a line as well.
static void widen_row(float *wide, const real *row, int width, int channels, int radius) {
    for (int x = -radius; x < width + radius; x++) {
        const real *from = row + (ptrdiff_t)channels * (x < 0 ? 0 : x >= width ? width - 1 : x);
        for (int c = 0; c < channels; c++) *wide++ = (float)from[c];
    }
}

void ffp_image_blur(FfpImage *image, real deviation) {
    const float sigma = (float)deviation;
    if (!(sigma > 0)) return;
    const int radius = (int)ceilf(3 * sigma), width = image->width, height = image->height;
    const size_t channels = (size_t)image->channels, row = (size_t)width * channels,
                 wide = row + 2 * (size_t)radius * channels;
    const Kernel kernel = {radius, ffp_alloc((size_t)radius * 2 + 1, sizeof *kernel.shares)};
    float total = 0;
    for (int k = -radius; k <= radius; k++)
        total += kernel.shares[k + radius] = expf(-0.5F * (float)(k * k) / (sigma * sigma));
    for (int k = 0; k <= 2 * radius; k++) kernel.shares[k] /= total;
    float *across = ffp_take(row * (size_t)height, sizeof *across),
          *all = ffp_take((size_t)omp_get_max_threads() * wide, sizeof *all);
#pragma omp parallel
    {
        float *own = all + (size_t)omp_get_thread_num() * wide;
#pragma omp for schedule(static)
        for (int y = 0; y < height; y++) {
            widen_row(own, image->data + (size_t)y * row, width, image->channels, radius);
            sum_lines(across + (size_t)y * row, row, &kernel, own, channels, 0, 2 * radius);
        }
#pragma omp for schedule(static)
        for (int y = 0; y < height; y++) {
            sum_lines(own, row, &kernel, across, row, y - radius, height - 1);
            for (size_t i = 0; i < row; i++) image->data[(size_t)y * row + i] = (real)own[i];
        }
    }
    ffp_free(all), ffp_free(across);
    ffp_free(kernel.shares);
}

#define REDUCED 4 // pixels, least deviation in a picture that was reduced for it

static bool is_plain(const FfpImage *image) {
    const size_t values = (size_t)image->width * (size_t)image->height * 3;
    for (size_t i = 3; i < values; i++)
        if (image->data[i] != image->data[i % 3]) return false;
    return true;
}

// The deviation left to a Gaussian between reducing by a factor and enlarging again: means over the factor
// have a twelfth of its square as variance, and the straight lines between them twice that.
static real left_after(real deviation, real factor) {
    return sqrtf((float)(deviation * deviation - factor * factor / 4)) / (float)factor;
}

void ffp_image_spread(FfpImage *image, const real share[3], real deviation) {
    if (!(deviation > 0) || is_plain(image)) return;
    const int factor = deviation > REDUCED ? (int)(deviation / REDUCED) : 1;
    const int width = (image->width + factor - 1) / factor, height = (image->height + factor - 1) / factor;
    FfpImage wide = ffp_image_resize(image, width, height);
    ffp_image_blur(&wide, factor > 1 ? left_after(deviation, (real)factor) : deviation);
    FfpImage around = ffp_image_resize(&wide, image->width, image->height);
    const ptrdiff_t values = (ptrdiff_t)image->width * image->height * 3;
#pragma omp parallel for schedule(static)
    for (ptrdiff_t i = 0; i < values; i++) image->data[i] += share[i % 3] * (around.data[i] - image->data[i]);
    ffp_image_free(&wide);
    ffp_image_free(&around);
}
