// Front-to-back blending of a tile's splats. A block's sums stay in registers while the splats of a batch
// that touch it pass by.
#include "engine/render/kernels/blocks.h"

// A block's pixels while they are blended.
typedef struct Sums {
    Lanes transmittance, distortion, value[FFP_CHANNELS];
} Sums;

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
        FFP_UNROLL(16)
        for (int k = 1; k < channels; k++) s.value[k] += splat->value[k] * w;
        if (i % 8 == 7 && !lanes_positive(s.transmittance)) break;
    }
    *sums = s;
}

// `count` pixels from `pixel` on: the block's lanes from `lane` on.
ALWAYS_INLINE void write_pixels(const Sums *sums, int lane, int64_t pixel, const int count,
                                const int channels, FfpGbuffer *out) {
    const Planes planes = gbuffer_planes(out, channels);
    FFP_UNROLL(16)
    for (int k = 0; k < channels; k++)
        for (int l = 0; l < count; l++)
            planes.plane[k][(pixel + l) * planes.stride[k]] = sums->value[k][lane + l];
    for (int l = 0; channels > FFP_SHADOW_CHANNELS && l < count; l++)
        out->distortion[pixel + l] = sums->distortion[lane + l];
}

ALWAYS_INLINE void write_block(const FfpRaster *raster, const Tile *tile, int b, const int channels,
                               const Sums *sums, FfpGbuffer *out) {
    const int x = lane_x(b, 0), wide = tile->width - x < BLOCK_WIDTH ? tile->width - x : BLOCK_WIDTH;
    for (int row = 0; row < BLOCK_HEIGHT && lane_y(b, row * BLOCK_WIDTH) < tile->height; row++) {
        const int64_t pixel =
            (int64_t)(tile->y0 + lane_y(b, row * BLOCK_WIDTH)) * raster->width + tile->x0 + x;
        if (wide == BLOCK_WIDTH)
            write_pixels(sums, row * BLOCK_WIDTH, pixel, BLOCK_WIDTH, channels, out);
        else
            write_pixels(sums, row * BLOCK_WIDTH, pixel, wide, channels, out);
    }
}

// Where no splat is. A row without opacity is clear already, as most are that another view left so.
static void clear_tile(const FfpRaster *raster, const Tile *tile, int channels, FfpGbuffer *out) {
    const Planes planes = gbuffer_planes(out, channels);
    for (int y = tile->y0; y < tile->y0 + tile->height; y++) {
        const size_t first = (size_t)y * (size_t)raster->width + (size_t)tile->x0,
                     row = sizeof(real) * (size_t)tile->width;
        int covered = 0;
        for (int x = 0; x < tile->width; x++) covered |= out->opacity[first + (size_t)x] != 0;
        if (!covered) continue;
        for (int k = 0; k < channels; k += planes.stride[k])
            memset(planes.plane[k] + first * (size_t)planes.stride[k], 0, row * (size_t)planes.stride[k]);
        if (out->distortion) memset(out->distortion + first, 0, row);
    }
}

ALWAYS_INLINE void blend_blocks(const FfpRaster *raster, const Tile *tile, const int channels, Sums *sums) {
    uint64_t open = ~(uint64_t)0 >> (64 - BLOCKS);
    Lists lists;
    for (int64_t first = 0; first < tile->count && open; first += BATCH_MAX) {
        const int32_t *batch = tile->order + first;
        const int count = tile->count - first < BATCH_MAX ? (int)(tile->count - first) : BATCH_MAX;
        list_batch(raster, tile, first, count, open, &lists);
        for (int b = 0; b < BLOCKS; b++) {
            if (!lists.count[b]) continue;
            blend_block(raster->splats, batch, lists.place[b], lists.count[b], block_columns(tile, b),
                        block_rows(tile, b), tile->firmness, channels, &sums[b]);
            if (!lanes_positive(sums[b].transmittance)) open &= ~((uint64_t)1 << b);
        }
    }
}

ALWAYS_INLINE void blend_channels(const FfpRaster *raster, const Tile *tile, const int channels,
                                  FfpGbuffer *out) {
    Sums sums[BLOCKS];
    memset(sums, 0, sizeof sums);
    for (int b = 0; b < BLOCKS; b++) sums[b].transmittance = start_transmittance(raster, tile, b);
    blend_blocks(raster, tile, channels, sums);
    for (int b = 0; b < BLOCKS; b++) write_block(raster, tile, b, channels, &sums[b], out);
}

void FFP_K(blend_tile)(const FfpRaster *raster, int t, int channels, FfpGbuffer *out) {
    const Tile tile = find_tile(raster, t);
    if (tile.count == 0)
        clear_tile(raster, &tile, channels, out);
    else if (channels == FFP_CHANNELS)
        blend_channels(raster, &tile, FFP_CHANNELS, out);
    else if (channels == FFP_DIRECT_CHANNELS)
        blend_channels(raster, &tile, FFP_DIRECT_CHANNELS, out);
    else
        blend_channels(raster, &tile, FFP_SHADOW_CHANNELS, out);
}
