// A tile is drawn in blocks of one vector of pixels: four wide, as high as the CPU level's registers allow.
#ifndef FFP_RENDER_KERNELS_BLOCKS_H
#define FFP_RENDER_KERNELS_BLOCKS_H

#include <string.h>
#include "engine/render/kernels/kernels.h"
#include "engine/render/kernels/lanes.h"

enum {
    BLOCK_WIDTH = 4,
    BLOCK_HEIGHT = LANES / BLOCK_WIDTH,
    BLOCKS_ACROSS = FFP_TILE / BLOCK_WIDTH,
    BLOCKS_DOWN = FFP_TILE / BLOCK_HEIGHT,
    BLOCKS = BLOCKS_ACROSS * BLOCKS_DOWN, // 64 at most: a set of them is one uint64_t
    BATCH_MAX = 256,                      // splats that are listed together
    FETCH_AHEAD = 12
};

// The planes of a G-buffer in channel order; each value is plane[k][pixel * stride[k]].
typedef struct Planes {
    real *plane[FFP_CHANNELS];
    int stride[FFP_CHANNELS];
} Planes;

static inline Planes gbuffer_planes(const FfpGbuffer *g, int channels) {
    Planes p = {.plane = {g->opacity, g->depth}, .stride = {1, 1, 3, 3, 3, 3, 3, 3, 1, 3, 3, 3, 3, 3, 3}};
    if (channels <= FFP_SHADOW_CHANNELS) return p;
    for (int k = 0; k < 3; k++) {
        p.plane[FFP_CHANNEL_NORMAL + k] = g->normal + k;
        p.plane[FFP_CHANNEL_ALBEDO + k] = g->albedo + k;
        p.plane[FFP_CHANNEL_AMBIENT + k] = g->ambient + k;
        if (channels == FFP_CHANNELS) p.plane[FFP_CHANNEL_SCATTERED + k] = g->scattered + k;
    }
    p.plane[FFP_CHANNEL_ROUGHNESS] = g->roughness;
    return p;
}

typedef struct Tile {
    int x0, y0, width, height; // pixels; width and height below FFP_TILE at the image's right and bottom
    const int32_t *order;
    int64_t count;
    real firmness; // of the settings
} Tile;

static inline Tile find_tile(const FfpRaster *raster, int t) {
    const int x0 = t % raster->tiles_x * FFP_TILE, y0 = t / raster->tiles_x * FFP_TILE;
    const int width = raster->width - x0, height = raster->height - y0;
    return (Tile){x0,
                  y0,
                  width < FFP_TILE ? width : FFP_TILE,
                  height < FFP_TILE ? height : FFP_TILE,
                  raster->order + raster->tile_first[t],
                  raster->tile_first[t + 1] - raster->tile_first[t],
                  raster->firmness};
}

// Where lane l of block b lies in the tile.
static inline int lane_x(int b, int l) {
    return b % BLOCKS_ACROSS * BLOCK_WIDTH + l % BLOCK_WIDTH;
}

static inline int lane_y(int b, int l) {
    return b / BLOCKS_ACROSS * BLOCK_HEIGHT + l / BLOCK_WIDTH;
}

// The pixel that lane l of block b is, or -1 outside the image.
static inline int64_t lane_pixel(const FfpRaster *raster, const Tile *tile, int b, int l) {
    const int x = lane_x(b, l), y = lane_y(b, l);
    if (x >= tile->width || y >= tile->height) return -1;
    return (int64_t)(tile->y0 + y) * raster->width + tile->x0 + x;
}

// The lanes' pixel centres.
ALWAYS_INLINE Lanes block_columns(const Tile *tile, int b) {
    static const real offsets[] = {0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3, 0, 1, 2, 3};
    Lanes x;
    memcpy(&x, offsets, sizeof x);
    return x + ((real)(tile->x0 + lane_x(b, 0)) + 0.5F);
}

ALWAYS_INLINE Lanes block_rows(const Tile *tile, int b) {
    static const real offsets[] = {0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 3, 3, 3, 3};
    Lanes y;
    memcpy(&y, offsets, sizeof y);
    return y + ((real)(tile->y0 + lane_y(b, 0)) + 0.5F);
}

// 1 inside the image, 0 (nothing can be added) outside.
static inline Lanes start_transmittance(const FfpRaster *raster, const Tile *tile, int b) {
    Lanes T;
    for (int l = 0; l < LANES; l++) T[l] = lane_pixel(raster, tile, b, l) < 0 ? 0 : 1;
    return T;
}

// Splats come in no order of memory: called some splats ahead of their use.
static inline void fetch_splat(const FfpRaster *raster, const Tile *tile, int64_t i) {
    if (i >= tile->count) return;
    const FfpSplat *s = &raster->splats[tile->order[i]];
    __builtin_prefetch(s);
    __builtin_prefetch((const char *)s + 64);
}

// The blocks that a splat's box touches; its tiles include this one.
static inline uint64_t splat_blocks(const FfpSplat *s, const Tile *tile) {
    const int x0 = s->x0 - tile->x0, y0 = s->y0 - tile->y0, x1 = s->x1 - tile->x0, y1 = s->y1 - tile->y0;
    const int left = x0 > 0 ? x0 / BLOCK_WIDTH : 0, top = y0 > 0 ? y0 / BLOCK_HEIGHT : 0;
    const int right = x1 < FFP_TILE ? (x1 - 1) / BLOCK_WIDTH : BLOCKS_ACROSS - 1;
    const int bottom = y1 < FFP_TILE ? (y1 - 1) / BLOCK_HEIGHT : BLOCKS_DOWN - 1;
    const uint64_t across = (2U << right) - (1U << left);
    uint64_t blocks = 0;
    for (int row = top; row <= bottom; row++) blocks |= across << (row * BLOCKS_ACROSS);
    return blocks;
}

// For each block the splats of a batch that may touch it, near to far, as places in the batch.
typedef struct Lists {
    int count[BLOCKS];
    uint8_t place[BLOCKS][BATCH_MAX];
} Lists;

static inline void list_batch(const FfpRaster *raster, const Tile *tile, int64_t first, int count,
                              uint64_t open, Lists *lists) {
    memset(lists->count, 0, sizeof lists->count);
    for (int i = 0; i < count; i++) {
        fetch_splat(raster, tile, first + i + FETCH_AHEAD);
        uint64_t blocks = splat_blocks(&raster->splats[tile->order[first + i]], tile) & open;
        for (; blocks; blocks &= blocks - 1) {
            const int b = __builtin_ctzll(blocks);
            lists->place[b][lists->count[b]++] = (uint8_t)i;
        }
    }
}

// A splat over a block: its density d, what that covers, and alpha, which is 0 where below 1/255 or where the
// pixel has come to its end.
typedef struct Cover {
    Lanes density, covered, alpha, before; // before: the transmittance in front of the splat
} Cover;

// Moves the transmittance on. A pixel whose transmittance would fall to 1e-4 stops, without this splat, and
// is marked by 0.
ALWAYS_INLINE Cover cover_block(const FfpSplat *s, Lanes columns, Lanes rows, real firmness,
                                Lanes *transmittance) {
    const Lanes dx = s->x - columns, dy = s->y - rows, none = {0};
    Lanes t = (s->power[0] * dx + s->power[1] * dy) * dx + s->power[2] * dy * dy;
    t = lanes_max(lanes_min(t, none), lanes_all(-100)); // 2^-100 is far below 1/255 as well
    Cover c = {.before = *transmittance};
    c.density = s->opacity * lanes_exp2(t);
    c.covered = c.density * (1.0F + firmness * (1.0F - c.density));
    const Lanes kept = lanes_keep(c.covered, c.covered >= lanes_all(FFP_ALPHA_MIN));
    const Lanes alpha = lanes_min(kept, lanes_all(FFP_ALPHA_MAX)), next = c.before * (1.0F - alpha);
    const Where open = next > lanes_all(FFP_TRANSMITTANCE_MIN);
    c.alpha = lanes_keep(alpha, open);
    *transmittance = lanes_keep(next, open);
    return c;
}

#endif
