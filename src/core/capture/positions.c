#include "core/capture/positions.h"
#include <tgmath.h>

#define AROUND ((real)0.25) // of a side, before and after the projector's picture
#define SPAN (1 + 2 * AROUND)

FfpImage ffp_positions_encoded(const FfpImage *map, int width, int height) {
    FfpImage out = ffp_image_new(map->width, map->height, 3);
    const real sides[2] = {(real)width, (real)height};
    const ptrdiff_t pixels = (ptrdiff_t)map->width * map->height;
    for (ptrdiff_t i = 0; i < pixels; i++) {
        const real *from = map->data + 3 * i;
        real *to = out.data + 3 * i;
        bool inside = from[2] > 0;
        for (int k = 0; k < 2; k++) {
            to[k] = (from[k] / sides[k] + AROUND) / SPAN;
            inside = inside && to[k] >= 0 && to[k] <= 1;
        }
        to[2] = from[2];
        for (int k = 0; k < 3 && !inside; k++) to[k] = 0;
    }
    return out;
}

FfpImage ffp_positions_decoded(const FfpImage *picture, int width, int height) {
    FfpImage out = ffp_image_new(picture->width, picture->height, 3);
    const real sides[2] = {(real)width, (real)height};
    const ptrdiff_t pixels = (ptrdiff_t)out.width * out.height;
    for (ptrdiff_t i = 0; i < pixels; i++) {
        const real *from = picture->data + picture->channels * i;
        real *to = out.data + 3 * i;
        to[2] = from[2];
        for (int k = 0; k < 2 && from[2] > 0; k++) to[k] = (from[k] * SPAN - AROUND) * sides[k];
    }
    return out;
}
