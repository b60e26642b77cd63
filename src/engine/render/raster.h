// Inside the render room: one view's projected splats, their order in every tile, and the steps between them.
#ifndef FFP_RENDER_RASTER_H
#define FFP_RENDER_RASTER_H

#include <stddef.h>
#include <stdint.h>
#include "engine/render/formula.h"
#include "engine/render/render.h"
#include "engine/render/table.h"

enum {
    FFP_CHUNKS = 64 // parts of a Gaussian set that are worked on apart, whatever the threads
};

// A Gaussian as one view sees it.
typedef struct FfpSplat {
    _Alignas(16) real x, y;   // centre in pixels
    real power[3];            // density = opacity 2^(p0 dx^2 + p1 dx dy + p2 dy^2)
    real opacity;             // compensated
    real value[FFP_CHANNELS]; // blended attributes, in the order of the enum
    int32_t gaussian;         // which Gaussian it is
    int32_t x0, y0, x1, y1;   // pixels it may touch, end exclusive
} FfpSplat;

// One tile's contribution to a splat's gradient. With dL/dsigma = g at each pixel, sigma = -log(density /
// opacity): the sums of g, g dx, g dy, g dx^2, g dx dy, g dy^2; and of w dL/d(channel). Channel 0 is
// constant.
typedef struct FfpSplatGrad {
    real g, gx, gy, gxx, gxy, gyy, value[FFP_CHANNELS];
} FfpSplatGrad;

typedef struct FfpDepthKey {
    uint32_t key; // bits of the depth as a float: for positive numbers they sort as the numbers do
    int32_t splat;
} FfpDepthKey;

// Gaussians [begin, end) of the set and their splats: `drawn` of them from `first` on, in the set's order.
typedef struct FfpChunk {
    int64_t begin, end;
    int32_t first, drawn;
    int64_t pairs; // of its splats with tiles
} FfpChunk;

struct FfpRaster {
    FfpDeviceRaster *device; // NULL: the CPU's, and what follows is in use
    int width, height, tiles_x, tiles_y;
    real firmness;    // of the settings
    int channels;     // that are blended
    int32_t n_splats; // Gaussians of opacity 1/255 and more: room for as many splats
    FfpChunk chunks[FFP_CHUNKS];
    FfpSplat *splats;
    int64_t instances;        // (splat, tile) pairs
    int64_t *first;           // [n_splats] where a drawn splat's pairs begin, row by row of its tiles
    int64_t *counts;          // [chunks, tiles] where a chunk's splats go in a tile's part of `keys`
    int64_t *tile_first;      // [tiles + 1] where a tile's splats begin in `keys` and `order`
    FfpDepthKey *keys, *swap; // [instances]
    int32_t *order;           // [instances] splats of every tile, near to far
    FfpSplatGrad *slots;      // [instances] gradients of every pair, splat by splat
    uint8_t *touched;         // [instances] whether the pair's slot holds anything
    size_t splats_size, first_size, counts_size, tile_first_size, keys_size, swap_size, order_size,
        slots_size, touched_size; // bytes
    FfpGbuffer shadow;            // the device's or the CPU's; of the planes only opacity and depth
};

// Makes *block hold at least `count` elements of `size` bytes; its contents are lost when it has to grow.
void ffp_raster_reserve(void **block, size_t *held, size_t count, size_t size);

// The tiles that a splat may touch, end exclusive.
typedef struct FfpTiles {
    int x0, y0, x1, y1;
} FfpTiles;

static inline FfpTiles ffp_splat_tiles(const FfpSplat *s) {
    return (FfpTiles){s->x0 / FFP_TILE, s->y0 / FFP_TILE, (s->x1 + FFP_TILE - 1) / FFP_TILE,
                      (s->y1 + FFP_TILE - 1) / FFP_TILE};
}

// project.c: fills chunks, splats, first and counts from the Gaussians of opacity >= 1/255. raster->width and
// ->height must be set.
void ffp_project_splats(FfpRaster *raster, const FfpGaussians *gaussians, const FfpCamera *camera,
                        const FfpRenderSettings *settings);
// Sums each splat's slots in order and adds what follows for the Gaussian's attributes to grad.
void ffp_project_splats_backward(const FfpRaster *raster, const FfpGaussians *gaussians,
                                 const FfpCamera *camera, const FfpRenderSettings *settings,
                                 FfpGaussians *grad);

// bin.c. First room for n_splats; then, while a chunk's splats are still in cache, their pairs with each tile
// into `counts` and `first`, and all of them into chunk->pairs; then tile_first and order from these.
void ffp_bin_reserve(FfpRaster *raster);
void ffp_bin_count(FfpRaster *raster, int chunk);
void ffp_bin_splats(FfpRaster *raster);

// blend.c: the first `channels` channels into out (and the distortion when all are asked for).
void ffp_blend(const FfpRaster *raster, int channels, FfpGbuffer *out);
void ffp_blend_backward(FfpRaster *raster, const FfpGbuffer *out, const FfpGbuffer *grad_out); // fills slots

#endif
