#include "core/patterns/patterns.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/real.h"
#include "core/patterns/lollipop.h"

enum { SPOKES = 36 };

FfpImage ffp_pattern_plain(int width, int height, int grey) {
    FfpImage image = ffp_image_new(width, height, 1);
    const size_t pixels = (size_t)width * (size_t)height;
    for (size_t i = 0; i < pixels; i++) image.data[i] = (real)grey / 255;
    return image;
}

int ffp_gray_code_bits(int size) {
    int bits = 1;
    while (bits < 31 && size > 1 << bits) bits++;
    return bits;
}

FfpImage ffp_pattern_gray_code(int width, int height, int axis, int bit, bool inverse) {
    FfpImage image = ffp_image_new(width, height, 1);
    const int shift = ffp_gray_code_bits(axis == 0 ? width : height) - 1 - bit;
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            const unsigned i = (unsigned)(axis == 0 ? x : y), code = i ^ (i >> 1);
            image.data[(size_t)y * (size_t)width + (size_t)x] = (real)((code >> shift & 1U) != inverse);
        }
    return image;
}

void ffp_gray_code_place(int width, int index, int *axis, int *bit) {
    const int columns = ffp_gray_code_bits(width), pair = index / 2;
    *axis = pair < columns ? 0 : 1;
    *bit = *axis == 0 ? pair : pair - columns;
}

void ffp_gray_code_name(int width, int index, char name[32]) {
    int axis, bit;
    ffp_gray_code_place(width, index, &axis, &bit);
    snprintf(name, 32, "gray_%c_%02d%s", axis == 0 ? 'x' : 'y', bit, index % 2 ? "_inverse" : "");
}

int ffp_gray_decode(const bool *bits, int count) {
    unsigned number = 0;
    for (int i = 0; i < count; i++) number = number << 1 | ((number & 1U) ^ (unsigned)bits[i]);
    return (int)number;
}

FfpImage ffp_pattern_round_lollipop(int width, int height, uint64_t seed) {
    const int side = width < height ? width : height, left = (width - side) / 2, top = (height - side) / 2;
    FfpImage round = ffp_lollipop_pattern(side, side, seed), image = ffp_image_new(width, height, 3);
    ffp_image_to_srgb(&round);
    for (int y = 0; y < side; y++)
        memcpy(image.data + 3 * ((size_t)(top + y) * (size_t)width + (size_t)left),
               round.data + 3 * (size_t)y * (size_t)side, 3 * (size_t)side * sizeof(real));
    ffp_image_free(&round);
    return image;
}

static void draw_star(FfpImage *image, double x, double y, double radius) {
    for (int j = (int)(y - radius); j <= (int)(y + radius); j++)
        for (int i = (int)(x - radius); i <= (int)(x + radius); i++) {
            const double dx = i + 0.5 - x, dy = j + 0.5 - y;
            if (i < 0 || j < 0 || i >= image->width || j >= image->height || hypot(dx, dy) > radius) continue;
            const double turn = (atan2(dy, dx) / FFP_PI_DOUBLE + 1) * (SPOKES / 2.0);
            image->data[(size_t)j * (size_t)image->width + (size_t)i] = (int)(2 * turn) % 2;
        }
}

FfpImage ffp_pattern_focus(int width, int height) {
    FfpImage image = ffp_image_new(width, height, 1);
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++)
            image.data[(size_t)y * (size_t)width + (size_t)x] =
                x == 0 || y == 0 || x == width - 1 || y == height - 1 || x == width / 2 || y == height / 2;
    const double radius = 0.12 * (width < height ? width : height);
    for (int j = -1; j <= 1; j++)
        for (int i = -1; i <= 1; i++)
            draw_star(&image, 0.5 * width + i * (0.47 * width - radius),
                      0.5 * height + j * (0.47 * height - radius), radius);
    return image;
}
