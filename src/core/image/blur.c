// Pictures through a Gaussian.
#include <math.h>
#include <omp.h>
#include "core/base/arena.h"
#include "core/image/image.h"

// One line through the Gaussian, its ends repeated; `step` values from one to the next.
static void blur_line(real *line, size_t step, int length, const float *kernel, int radius, float *keep) {
    for (int i = 0; i < length; i++) keep[i] = (float)line[(size_t)i * step];
    for (int i = 0; i < length; i++) {
        float sum = 0;
        for (int k = -radius; k <= radius; k++) {
            const int j = i + k < 0 ? 0 : i + k >= length ? length - 1 : i + k;
            sum += kernel[k + radius] * keep[j];
        }
        line[(size_t)i * step] = (real)sum;
    }
}

void ffp_image_blur(FfpImage *image, real deviation) {
    const float sigma = (float)deviation;
    if (!(sigma > 0)) return;
    const int radius = (int)ceilf(3 * sigma), width = image->width, height = image->height;
    const size_t channels = (size_t)image->channels, row = (size_t)width * channels;
    float *kernel = ffp_alloc((size_t)radius * 2 + 1, sizeof *kernel), total = 0;
    for (int k = -radius; k <= radius; k++)
        total += kernel[k + radius] = expf(-0.5F * (float)(k * k) / (sigma * sigma));
    for (int k = 0; k <= 2 * radius; k++) kernel[k] /= total;
    const size_t longest = (size_t)(width > height ? width : height);
    float *all = ffp_alloc((size_t)omp_get_max_threads() * longest, sizeof *all);
#pragma omp parallel
    {
        float *keep = all + (size_t)omp_get_thread_num() * longest;
#pragma omp for schedule(static)
        for (int y = 0; y < height; y++)
            for (size_t c = 0; c < channels; c++)
                blur_line(image->data + (size_t)y * row + c, channels, width, kernel, radius, keep);
#pragma omp for schedule(static)
        for (int x = 0; x < width; x++)
            for (size_t c = 0; c < channels; c++)
                blur_line(image->data + (size_t)x * channels + c, row, height, kernel, radius, keep);
    }
    ffp_free(all);
    ffp_free(kernel);
}
