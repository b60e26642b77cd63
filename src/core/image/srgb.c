// The sRGB transfer functions over pictures, and the share of a pixel that the object fills.
#include <tgmath.h>
#include "core/base/device.h"
#include "core/image/image.h"
#include "core/image/table.h"

#define COVERAGE_MIN 0.05F // a silhouette's colours are divided by no less

void ffp_own_radiance(real own[3], const real shown[3], real coverage) {
    const bool whole = coverage >= 1;
    const real share = fmax(coverage, COVERAGE_MIN);
    for (int c = 0; c < 3; c++)
        own[c] = whole ? shown[c] : ffp_srgb_decode(fmin(ffp_srgb_encode(shown[c]) / share, 1));
}

void ffp_shown_radiance(real shown[3], const real light[3], real coverage) {
    const bool whole = coverage >= 1;
    const real share = fmax(coverage, COVERAGE_MIN);
    for (int c = 0; c < 3; c++)
        shown[c] = whole ? light[c] : ffp_srgb_decode(coverage * ffp_srgb_encode(light[c] / share));
}

// A row through the curve. Patterns are even over long stretches: a value that repeats its left neighbour's
// takes over the result.
static void encode_row(real *row, int width, int channels) {
    const int colours = channels == 4 ? 3 : channels;
    real from[4] = {0}, to[4];
    for (int c = 0; c < colours; c++) to[c] = ffp_srgb_encode(0);
    for (int x = 0; x < width; x++) {
        for (int c = 0; c < colours; c++) {
            real *value = row + (ptrdiff_t)x * channels + c;
            if (*value != from[c]) {
                from[c] = *value;
                to[c] = ffp_srgb_encode(*value);
            }
            *value = to[c];
        }
    }
}

// Back. Files of 8 bits hold 256 values: a thread decodes each of them once, to the curve's own result.
typedef struct Decoded {
    real from[256], to[256];
} Decoded;

static void decode_row(real *row, int width, int channels, Decoded *known) {
    const int colours = channels == 4 ? 3 : channels;
    real *const from = known->from, *const to = known->to;
    for (int x = 0; x < width; x++) {
        for (int c = 0; c < colours; c++) {
            real *value = row + (ptrdiff_t)x * channels + c;
            const real inside = *value > 0 ? (*value < 1 ? *value : 1) : 0;
            const int k = (int)(255 * inside + (real)0.5);
            if (*value != from[k]) {
                from[k] = *value;
                to[k] = ffp_srgb_decode(*value);
            }
            *value = to[k];
        }
    }
}

static void encode_rows(FfpImage *image) {
    const ptrdiff_t row = (ptrdiff_t)image->width * image->channels;
#pragma omp parallel for schedule(static)
    for (int y = 0; y < image->height; y++) encode_row(image->data + y * row, image->width, image->channels);
}

static void decode_rows(FfpImage *image) {
    const ptrdiff_t row = (ptrdiff_t)image->width * image->channels;
#pragma omp parallel
    {
        Decoded known = {{0}, {0}};
#pragma omp for schedule(static)
        for (int y = 0; y < image->height; y++)
            decode_row(image->data + y * row, image->width, image->channels, &known);
    }
}

void ffp_image_to_srgb(FfpImage *image) {
    if (ffp_device())
        ffp_device()->image->to_srgb(image);
    else
        encode_rows(image);
}

void ffp_image_to_linear(FfpImage *image) {
    if (ffp_device())
        ffp_device()->image->to_linear(image);
    else
        decode_rows(image);
}
