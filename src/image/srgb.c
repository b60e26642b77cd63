// The sRGB transfer functions of IEC 61966-2-1.
#include <tgmath.h>

#include "image/image.h"

real ffp_srgb_encode(real linear) {
    if (!(linear > 0)) return 0;
    if (linear >= 1) return 1;
    if (linear <= 0.0031308F) return linear * 12.92F;
    return 1.055F * pow(linear, (real)(1 / 2.4)) - 0.055F;
}

real ffp_srgb_decode(real encoded) {
    if (encoded <= 0.04045F) return encoded / 12.92F;
    return pow((encoded + 0.055F) / 1.055F, (real)2.4);
}

real ffp_srgb_encode_slope(real linear) {
    if (!(linear >= 0) || linear > 1) return 0;
    if (linear <= 0.0031308F) return 12.92F;
    return (real)(1.055 / 2.4) * pow(linear, (real)(1 / 2.4 - 1));
}

static void map_colours(FfpImage *image, real (*curve)(real)) {
    const int channels = image->channels, colours = channels == 4 ? 3 : channels;
    const ptrdiff_t pixels = (ptrdiff_t)image->width * image->height;
#pragma omp parallel for schedule(static)
    for (ptrdiff_t i = 0; i < pixels; i++) {
        for (int c = 0; c < colours; c++)
            image->data[i * channels + c] = curve(image->data[i * channels + c]);
    }
}

void ffp_image_to_srgb(FfpImage *image) {
    map_colours(image, ffp_srgb_encode);
}

void ffp_image_to_linear(FfpImage *image) {
    map_colours(image, ffp_srgb_decode);
}
