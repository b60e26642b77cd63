// Front-to-back blending of a tile's splats. A block's sums stay in registers while the splats of a batch
// that touch it pass by.
#include "render/kernels/blocks.h"

enum { BATCH = 256 };

// A block's pixels while they are blended.
typedef struct Sums {
    Lanes transmittance, distortion, value[FFP_CHANNELS];
} Sums;

// For each block the splats of a batch that may touch it, near to far, as places in the batch.
typedef struct Lists {
    int count[BLOCKS];
    uint8_t place[BLOCKS][BATCH];
} Lists;

static void list_batch(const FfpRaster *raster, const Tile *tile, int64_t first, int count, uint64_t open,
                       Lists *lists) {
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

// Distortion: each splat's pairs with those in front of it, twice: 2 w (z sum w_j - sum w_j z_j).
ALWAYS_INLINE void blend_block(const FfpSplat *splats, const int32_t *batch, const uint8_t *places, int count,
                               Lanes columns, Lanes rows, real firmness, const int channels, Sums *sums) {
    Sums s = *sums;
    for (int i = 0; i < count; i++) {
        const FfpSplat *splat = &splats[batch[places[i]]];
        const Cover c = cover_block(splat, columns, rows, firmness, &s.transmittance);
        const Lanes w = c.alpha * c.before;
        if (channels > FFP_SHADOW_CHANNELS)
            s.distortion += 2 * w * (splat->value[FFP_CHANNEL_DEPTH] * s.value[0] - s.value[1]);
        s.value[0] += w;
#pragma GCC unroll 12
        for (int k = 1; k < channels; k++) s.value[k] += splat->value[k] * w;
        if (i % 8 == 7 && !lanes_bits(s.transmittance > (Lanes){0})) break;
    }
    *sums = s;
}

static void write_block(const FfpRaster *raster, const Tile *tile, int b, int channels, const Sums *sums,
                        FfpGbuffer *out) {
    const Planes planes = gbuffer_planes(out, channels);
    for (int l = 0; l < LANES; l++) {
        const int64_t pixel = lane_pixel(raster, tile, b, l);
        if (pixel < 0) continue;
        for (int k = 0; k < channels; k++) planes.plane[k][pixel * planes.stride[k]] = sums->value[k][l];
        if (out->distortion) out->distortion[pixel] = sums->distortion[l];
    }
}

ALWAYS_INLINE void blend_blocks(const FfpRaster *raster, const Tile *tile, const int channels, Sums *sums) {
    uint64_t open = ~(uint64_t)0 >> (64 - BLOCKS);
    Lists lists;
    for (int64_t first = 0; first < tile->count && open; first += BATCH) {
        const int32_t *batch = tile->order + first;
        const int count = tile->count - first < BATCH ? (int)(tile->count - first) : BATCH;
        list_batch(raster, tile, first, count, open, &lists);
        for (int b = 0; b < BLOCKS; b++) {
            if (!lists.count[b]) continue;
            blend_block(raster->splats, batch, lists.place[b], lists.count[b], block_columns(tile, b),
                        block_rows(tile, b), tile->firmness, channels, &sums[b]);
            if (!lanes_bits(sums[b].transmittance > (Lanes){0})) open &= ~((uint64_t)1 << b);
        }
    }
}

void FFP_K(blend_tile)(const FfpRaster *raster, int t, int channels, FfpGbuffer *out) {
    const Tile tile = find_tile(raster, t);
    Sums sums[BLOCKS];
    memset(sums, 0, sizeof sums);
    for (int b = 0; b < BLOCKS; b++) sums[b].transmittance = start_transmittance(raster, &tile, b);
    if (channels > FFP_SHADOW_CHANNELS)
        blend_blocks(raster, &tile, FFP_CHANNELS, sums);
    else
        blend_blocks(raster, &tile, FFP_SHADOW_CHANNELS, sums);
    for (int b = 0; b < BLOCKS; b++) write_block(raster, &tile, b, channels, &sums[b], out);
}
