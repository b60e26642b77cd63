// Which splats each tile has to draw, near to far: a radix sort by depth, then a counting sort by tile that
// keeps it.
#include <string.h>
#include "render/raster.h"

enum { DIGIT_BITS = 11, DIGITS = 1 << DIGIT_BITS, PASSES = (8 * sizeof(real) + DIGIT_BITS - 1) / DIGIT_BITS };

static uint64_t depth_bits(real depth) {
    uint64_t bits = 0;
    memcpy(&bits, &depth, sizeof depth); // little-endian: a float fills the low half
    return bits;
}

// Least significant digit first; equal depths stay in the set's order. Returns the sorted array of the two.
static const FfpDepthKey *sort_by_depth(FfpDepthKey *from, FfpDepthKey *to, int32_t count) {
    for (int pass = 0; pass < PASSES; pass++) {
        int32_t start[DIGITS] = {0}, total = 0;
        const int shift = pass * DIGIT_BITS;
        for (int32_t i = 0; i < count; i++) start[(from[i].key >> shift) & (DIGITS - 1)]++;
        for (int d = 0; d < DIGITS; d++) {
            const int32_t here = start[d];
            start[d] = total;
            total += here;
        }
        for (int32_t i = 0; i < count; i++) to[start[(from[i].key >> shift) & (DIGITS - 1)]++] = from[i];
        FfpDepthKey *swap = from;
        from = to, to = swap;
    }
    return from;
}

// Counts the tiles of every splat and the splats of every tile; lists the drawn splats' depths.
static int32_t count_instances(FfpRaster *raster) {
    int64_t *tile_count = raster->tile_first + 1;
    int32_t drawn = 0;
    raster->first[0] = 0;
    for (int32_t s = 0; s < raster->n_splats; s++) {
        const FfpSplat *splat = &raster->splats[s];
        raster->first[s + 1] = raster->first[s];
        if (splat->opacity == 0) continue;
        raster->first[s + 1] +=
            (int64_t)(splat->tile_x1 - splat->tile_x0) * (splat->tile_y1 - splat->tile_y0);
        for (int ty = splat->tile_y0; ty < splat->tile_y1; ty++)
            for (int tx = splat->tile_x0; tx < splat->tile_x1; tx++) tile_count[ty * raster->tiles_x + tx]++;
        raster->keys[drawn++] = (FfpDepthKey){depth_bits(splat->value[FFP_CHANNEL_DEPTH]), s};
    }
    return drawn;
}

void ffp_bin_splats(FfpRaster *raster) {
    const size_t tiles = (size_t)raster->tiles_x * (size_t)raster->tiles_y, splats = (size_t)raster->n_splats;
    ffp_raster_reserve((void **)&raster->keys, &raster->keys_size, splats + 1, sizeof(FfpDepthKey));
    ffp_raster_reserve((void **)&raster->keys_swap, &raster->keys_swap_size, splats + 1, sizeof(FfpDepthKey));
    ffp_raster_reserve((void **)&raster->first, &raster->first_size, splats + 1, sizeof(int64_t));
    ffp_raster_reserve((void **)&raster->tile_first, &raster->tile_first_size, tiles + 2, sizeof(int64_t));
    memset(raster->tile_first, 0, (tiles + 2) * sizeof(int64_t));
    const int32_t drawn = count_instances(raster);
    const FfpDepthKey *sorted = sort_by_depth(raster->keys, raster->keys_swap, drawn);

    ffp_raster_reserve((void **)&raster->order, &raster->order_size, (size_t)raster->first[splats] + 1,
                       sizeof(int32_t));
    for (size_t t = 0; t < tiles; t++) raster->tile_first[t + 1] += raster->tile_first[t];
    // The counts' sums are now the tiles' ends. Filled far to near they come down to the tiles' beginnings,
    // one place up.
    int64_t *end = raster->tile_first + 1;
    for (int32_t i = drawn - 1; i >= 0; i--) {
        const FfpSplat *splat = &raster->splats[sorted[i].splat];
        for (int ty = splat->tile_y0; ty < splat->tile_y1; ty++)
            for (int tx = splat->tile_x0; tx < splat->tile_x1; tx++)
                raster->order[--end[ty * raster->tiles_x + tx]] = sorted[i].splat;
    }
    memmove(raster->tile_first, end, tiles * sizeof(int64_t));
    raster->tile_first[tiles] = raster->first[splats];
}
