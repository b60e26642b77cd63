// A row of pixels to the projector (map_pixel.h): in parts, number by number in columns, which gcc
// vectorises.
#include <string.h>
#include "engine/render/kernels/kernels.h"
#include "engine/render/kernels/lanes.h"

enum { PART = 16 };

// As FfpAround.
typedef struct AroundColumns {
    real opacity[5][PART], depth[5][PART];
} AroundColumns;

typedef struct PlaceColumns {
    real uv[2][PART], extent[2][PART], depth[PART], inside[PART]; // inside: 1 or 0
} PlaceColumns;

// Sums of row y from pixel x on; 0 outside the picture.
static void load_row(const FfpGbuffer *g, int x, int y, real opacity[PART], real depth[PART]) {
    const int first = x < 0 ? 1 : 0, end = x + PART < g->width ? PART : g->width - x;
    const bool there = y >= 0 && y < g->height && first < end;
    const ptrdiff_t p = (ptrdiff_t)y * g->width + x;
    if (!there || end - first < PART) {
        memset(opacity, 0, PART * sizeof *opacity);
        memset(depth, 0, PART * sizeof *depth);
    }
    if (!there) return;
    memcpy(opacity + first, g->opacity + p + first, (size_t)(end - first) * sizeof *opacity);
    memcpy(depth + first, g->depth + p + first, (size_t)(end - first) * sizeof *depth);
}

// False where there is no surface.
static bool load_around(const FfpGbuffer *g, int x, int y, AroundColumns *c) {
    static const int dx[5] = {0, -1, 1, 0, 0}, dy[5] = {0, 0, 0, -1, 1};
    unsigned any = 0;
    load_row(g, x, y, c->opacity[0], c->depth[0]);
    for (int i = 0; i < PART; i++) any |= c->opacity[0][i] > FFP_OPACITY_MIN ? 1 : 0;
    for (int n = 1; any && n < 5; n++) load_row(g, x + dx[n], y + dy[n], c->opacity[n], c->depth[n]);
    return any != 0;
}

__attribute__((flatten)) static void place_part(const FfpMapper *m, int x, int y, const AroundColumns *c,
                                                PlaceColumns *out) {
#pragma GCC ivdep
    for (int i = 0; i < PART; i++) {
        const FfpAround around = {
            {c->opacity[0][i], c->opacity[1][i], c->opacity[2][i], c->opacity[3][i], c->opacity[4][i]},
            {c->depth[0][i], c->depth[1][i], c->depth[2][i], c->depth[3][i], c->depth[4][i]}};
        const FfpMapPlace place = ffp_pattern_place(m, x + i, y, &around);
        out->uv[0][i] = place.uv[0], out->uv[1][i] = place.uv[1];
        out->extent[0][i] = place.extent[0], out->extent[1][i] = place.extent[1];
        out->depth[i] = place.depth;
        out->inside[i] = place.inside ? 1 : 0;
    }
}

void FFP_K(map_row)(const FfpMapper *mapper, int y, FfpMapping *out) {
    const int width = mapper->gbuffer->width;
    for (int x = 0; x < width; x += PART) {
        const int count = x + PART < width ? PART : width - x;
        const ptrdiff_t p = (ptrdiff_t)y * width + x;
        AroundColumns around;
        PlaceColumns c = {.depth = {0}};
        if (load_around(mapper->gbuffer, x, y, &around)) place_part(mapper, x, y, &around, &c);
        for (int i = 0; i < count; i++) {
            const FfpMapPlace place = {
                c.inside[i] > 0, {c.uv[0][i], c.uv[1][i]}, {c.extent[0][i], c.extent[1][i]}, c.depth[i]};
            ffp_map_place(mapper, &place, p + i, out);
        }
    }
}
