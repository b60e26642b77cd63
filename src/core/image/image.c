#include "core/image/image.h"
#include <string.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "core/base/device.h"

static size_t value_count(const FfpImage *image) {
    return (size_t)image->width * (size_t)image->height * (size_t)image->channels;
}

FfpImage ffp_image_new(int width, int height, int channels) {
    FfpImage image = {width, height, channels, NULL};
    image.data = ffp_memory_new(value_count(&image), sizeof(real));
    return image;
}

void ffp_image_free(FfpImage *image) {
    if (!image) return;
    ffp_memory_free(image->data);
    *image = (FfpImage){0};
}

FfpImage ffp_image_copy(const FfpImage *image) {
    if (!image->data) return (FfpImage){0};
    FfpImage copy = ffp_image_new(image->width, image->height, image->channels);
    ffp_memory_copy(copy.data, image->data, value_count(image) * sizeof(real));
    return copy;
}

double ffp_image_mean(const FfpImage *image) {
    const size_t count = value_count(image);
    double sum = 0;
    for (size_t i = 0; i < count; i++) sum += (double)image->data[i];
    return sum / (double)count;
}

void ffp_image_put_over_black(FfpImage *image) {
    const size_t pixels = (size_t)image->width * (size_t)image->height;
    for (size_t i = 0; i < pixels; i++) {
        const real *from = image->data + 4 * i, alpha = from[3];
        const real rgb[3] = {from[0] * alpha, from[1] * alpha, from[2] * alpha};
        memcpy(image->data + 3 * i, rgb, sizeof rgb);
    }
    image->channels = 3;
    image->data = ffp_shrink(image->data, 3 * pixels, sizeof *image->data);
}

FfpImage ffp_image_channel(const FfpImage *image, int channel) {
    FfpImage out = ffp_image_new(image->width, image->height, 1);
    const ptrdiff_t pixels = (ptrdiff_t)image->width * image->height;
    for (ptrdiff_t i = 0; i < pixels; i++) out.data[i] = image->data[image->channels * i + channel];
    return out;
}

FfpImage ffp_mask_of(const FfpImage *rgba) {
    FfpImage mask = ffp_image_new(rgba->width, rgba->height, 1);
    const ptrdiff_t pixels = (ptrdiff_t)mask.width * mask.height;
    for (ptrdiff_t i = 0; i < pixels; i++) mask.data[i] = rgba->data[4 * i] * rgba->data[4 * i + 3];
    return mask;
}

void ffp_mask_apply(const FfpImage *mask, FfpImage *image) {
    const ptrdiff_t values = image->data ? (ptrdiff_t)image->width * image->height * 3 : 0;
    for (ptrdiff_t i = 0; i < values; i++) {
        const real m = mask->data[i / 3];
        if (m < 1) image->data[i] = m > 0 ? ffp_srgb_decode(ffp_srgb_encode(image->data[i]) * m) : 0;
    }
}

// Position u on an axis of n pixels: the two neighbours and the second's weight. NaN goes to the first pixel.
static void bilinear_axis(real u, int n, int *first, int *second, real *weight) {
    real x = u - 0.5F;
    if (!(x > 0)) x = 0;
    if (x > (real)(n - 1)) x = (real)(n - 1);
    *first = (int)x;
    *second = *first + 1 < n ? *first + 1 : *first;
    *weight = x - (real)*first;
}

static inline void sample(const FfpImage *image, const size_t n, real u, real v, real *out) {
    int x0, x1, y0, y1;
    real a, b;
    bilinear_axis(u, image->width, &x0, &x1, &a);
    bilinear_axis(v, image->height, &y0, &y1, &b);
    const size_t stride = n * (size_t)image->width;
    const real *top = image->data + (size_t)y0 * stride, *bottom = image->data + (size_t)y1 * stride;
    const real *p00 = top + (size_t)x0 * n, *p10 = top + (size_t)x1 * n;
    const real *p01 = bottom + (size_t)x0 * n, *p11 = bottom + (size_t)x1 * n;
    for (size_t c = 0; c < n; c++) {
        out[c] = (p00[c] * (1 - a) + p10[c] * a) * (1 - b) + (p01[c] * (1 - a) + p11[c] * a) * b;
    }
}

void ffp_image_sample(const FfpImage *image, real u, real v, real *out) {
    if (image->channels == 3)
        sample(image, 3, u, v, out);
    else
        sample(image, (size_t)image->channels, u, v, out);
}
