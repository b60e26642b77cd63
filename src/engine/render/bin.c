// Which splats each tile has to draw, near to far: a counting sort by tile that keeps the set's order, then a
// radix sort of each tile's splats by depth. The chunks write to places that are counted beforehand.
#include <string.h>
#include "engine/render/raster.h"

enum { DIGIT_BITS = 8, DIGITS = 1 << DIGIT_BITS };

static uint32_t depth_bits(real depth) {
    const float narrow = (float)depth;
    uint32_t bits;
    memcpy(&bits, &narrow, sizeof bits);
    return bits;
}

void ffp_bin_reserve(FfpRaster *raster) {
    const size_t tiles = (size_t)raster->tiles_x * (size_t)raster->tiles_y;
    ffp_raster_reserve((void **)&raster->first, &raster->first_size, (size_t)raster->n_splats + 1,
                       sizeof(int64_t));
    ffp_raster_reserve((void **)&raster->counts, &raster->counts_size, tiles * FFP_CHUNKS + 1,
                       sizeof(int64_t));
    ffp_raster_reserve((void **)&raster->tile_first, &raster->tile_first_size, tiles + 1, sizeof(int64_t));
}

void ffp_bin_count(FfpRaster *raster, int c) {
    FfpChunk *chunk = &raster->chunks[c];
    const int64_t tiles = (int64_t)raster->tiles_x * raster->tiles_y;
    int64_t *counts = raster->counts + c * tiles, pairs = 0;
    memset(counts, 0, (size_t)tiles * sizeof *counts);
    for (int32_t s = chunk->first; s < chunk->first + chunk->drawn; s++) {
        const FfpTiles t = ffp_splat_tiles(&raster->splats[s]);
        raster->first[s] = pairs;
        pairs += (int64_t)(t.x1 - t.x0) * (t.y1 - t.y0);
        for (int y = t.y0; y < t.y1; y++)
            for (int x = t.x0; x < t.x1; x++) counts[y * raster->tiles_x + x]++;
    }
    chunk->pairs = pairs;
}

// Turns the counts into places: tile by tile, in a tile chunk by chunk.
static void place_chunks(FfpRaster *raster) {
    const int64_t tiles = (int64_t)raster->tiles_x * raster->tiles_y;
    int64_t *first = raster->tile_first; // first and then the next place of each tile
    memset(first, 0, (size_t)(tiles + 1) * sizeof *first);
    for (int c = 0; c < FFP_CHUNKS; c++)
        for (int64_t t = 0; t < tiles; t++) first[t + 1] += raster->counts[c * tiles + t];
    for (int64_t t = 0; t < tiles; t++) first[t + 1] += first[t];
    for (int c = 0; c < FFP_CHUNKS; c++)
        for (int64_t t = 0; t < tiles; t++) {
            int64_t *count = &raster->counts[c * tiles + t];
            const int64_t here = *count;
            *count = first[t];
            first[t] += here;
        }
    memmove(first + 1, first, (size_t)tiles * sizeof *first); // a tile's next is now the first of the next
    first[0] = 0;
}

static void fill_chunk(FfpRaster *raster, const FfpChunk *chunk, int64_t before, int64_t *places) {
    for (int32_t s = chunk->first; s < chunk->first + chunk->drawn; s++) {
        const FfpTiles t = ffp_splat_tiles(&raster->splats[s]);
        const FfpDepthKey key = {depth_bits(raster->splats[s].value[FFP_CHANNEL_DEPTH]), s};
        raster->first[s] += before;
        for (int y = t.y0; y < t.y1; y++)
            for (int x = t.x0; x < t.x1; x++) raster->keys[places[y * raster->tiles_x + x]++] = key;
    }
}

// Least significant digit first, over the bits in which the keys differ from the least; equal depths stay in
// the set's order.
static void sort_tile(FfpDepthKey *from, FfpDepthKey *to, int64_t count, int32_t *order) {
    uint32_t least = UINT32_MAX, most = 0;
    for (int64_t i = 0; i < count; i++) {
        least = from[i].key < least ? from[i].key : least;
        most = from[i].key > most ? from[i].key : most;
    }
    for (int shift = 0; count && shift < 32 && (most - least) >> shift; shift += DIGIT_BITS) {
        int64_t start[DIGITS] = {0}, total = 0;
        for (int64_t i = 0; i < count; i++) start[((from[i].key - least) >> shift) & (DIGITS - 1)]++;
        for (int d = 0; d < DIGITS; d++) {
            const int64_t here = start[d];
            start[d] = total;
            total += here;
        }
        for (int64_t i = 0; i < count; i++)
            to[start[((from[i].key - least) >> shift) & (DIGITS - 1)]++] = from[i];
        FfpDepthKey *swap = from;
        from = to;
        to = swap;
    }
    for (int64_t i = 0; i < count; i++) order[i] = from[i].splat;
}

static void reserve_pairs(FfpRaster *raster) {
    const size_t pairs = (size_t)raster->instances + 1;
    ffp_raster_reserve((void **)&raster->keys, &raster->keys_size, pairs, sizeof(FfpDepthKey));
    ffp_raster_reserve((void **)&raster->swap, &raster->swap_size, pairs, sizeof(FfpDepthKey));
    ffp_raster_reserve((void **)&raster->order, &raster->order_size, pairs, sizeof(int32_t));
}

void ffp_bin_splats(FfpRaster *raster) {
    const int tiles = raster->tiles_x * raster->tiles_y;
    int64_t before[FFP_CHUNKS];
    raster->instances = 0;
    for (int c = 0; c < FFP_CHUNKS; c++) {
        before[c] = raster->instances;
        raster->instances += raster->chunks[c].pairs;
    }
    place_chunks(raster);
    reserve_pairs(raster);
#pragma omp parallel for schedule(static)
    for (int c = 0; c < FFP_CHUNKS; c++)
        fill_chunk(raster, &raster->chunks[c], before[c], raster->counts + (int64_t)c * tiles);
#pragma omp parallel for schedule(dynamic)
    for (int t = 0; t < tiles; t++) {
        const int64_t first = raster->tile_first[t];
        sort_tile(raster->keys + first, raster->swap + first, raster->tile_first[t + 1] - first,
                  raster->order + first);
    }
}
