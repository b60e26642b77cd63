// The lollipop of Nepmap's generator, which FF-ProCams uses: 30 nested ellipses, each cut into 8 sectors of
// 45 degrees from the x axis clockwise on the screen, every field its own colour. Ellipse i has the half axes
// w/2 - i sx and h/2 - i sy with sx = w / 60 and sy = h / 60 rounded down.
#include "core/patterns/lollipop.h"
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include "core/base/arena.h"
#include "core/base/rng.h"

static bool inside(double x, double y, double half_x, double half_y) {
    return half_x > 0 && half_y > 0 && x * x / (half_x * half_x) + y * y / (half_y * half_y) <= 1;
}

static int ring_of(double x, double y, int width, int height) {
    const int sx = width / (2 * FFP_LOLLIPOP_RINGS), sy = height / (2 * FFP_LOLLIPOP_RINGS);
    int low = -1,
        high = FFP_LOLLIPOP_RINGS; // inside all up to low, outside all from high: the ellipses are nested
    while (high - low > 1) {
        const int middle = (low + high) / 2;
        if (inside(x, y, 0.5 * width - sx * middle, 0.5 * height - sy * middle))
            low = middle;
        else
            high = middle;
    }
    return low;
}

static int sector_of(double x, double y) { // y down, so that angles grow clockwise on the screen
    if (y >= 0 && x > 0) return y < x ? 0 : 1;
    if (x <= 0 && y > 0) return -x < y ? 2 : 3;
    if (y <= 0 && x < 0) return -y < -x ? 4 : 5;
    return x < -y ? 6 : 7;
}

uint8_t *ffp_lollipop_map(int width, int height) {
    uint8_t *map = ffp_alloc((size_t)width * (size_t)height, 1);
#pragma omp parallel for schedule(static)
    for (int j = 0; j < height; j++)
        for (int i = 0; i < width; i++) {
            const double x = i + 0.5 - 0.5 * width, y = j + 0.5 - 0.5 * height;
            const int ring = ring_of(x, y, width, height);
            map[(size_t)j * (size_t)width + (size_t)i] =
                (uint8_t)(ring < 0 ? FFP_LOLLIPOP_FIELDS : ring * FFP_LOLLIPOP_SECTORS + sector_of(x, y));
        }
    return map;
}

FfpImage ffp_lollipop_paint(const uint8_t *map, int width, int height, uint64_t seed) {
    real colour[FFP_LOLLIPOP_FIELDS + 1][3] = {{0}};
    FfpRng rng = ffp_rng(seed, 0x10111909ULL);
    for (int f = 0; f < FFP_LOLLIPOP_FIELDS; f++)
        for (int c = 0; c < 3; c++) colour[f][c] = ffp_srgb_decode((real)ffp_rng_below(&rng, 255) / 255);
    FfpImage image = ffp_image_new(width, height, 3);
    const size_t pixels = (size_t)width * (size_t)height;
    for (size_t i = 0; i < pixels; i++)
        for (size_t c = 0; c < 3; c++) image.data[3 * i + c] = colour[map[i]][c];
    return image;
}

FfpImage ffp_lollipop_pattern(int width, int height, uint64_t seed) {
    uint8_t *map = ffp_lollipop_map(width, height);
    FfpImage image = ffp_lollipop_paint(map, width, height, seed);
    ffp_free(map);
    return image;
}
