// The instructions of Intel AMX that products use, or the same in plain C: inside the kernels folder only.
// Tile numbers must be constants. Intel 64 and IA-32 Architectures Software Developer's Manual, volume 1,
// chapter 18, and volume 2: LDTILECFG, TDPBF16PS, TILELOADD, TILESTORED, TILEZERO.
#ifndef FFP_TENSOR_KERNELS_TILES_H
#define FFP_TENSOR_KERNELS_TILES_H

#include <stdint.h>
#include <string.h>

enum { FFP_TILES_COUNT = 8, FFP_TILE_ROWS = 16, FFP_TILE_BYTES = 64 }; // bytes: of a row

// The operand of LDTILECFG: the rows and the bytes a row of every tile, palette 1.
typedef struct FfpTileShapes {
    uint8_t palette, start_row, reserved[14];
    uint16_t row_bytes[16];
    uint8_t rows[16];
} FfpTileShapes;

#ifndef FFP_EMULATED_TILES
#include <immintrin.h>
// gcc's intrinsic declares only the first 8 bytes as read: the empty statement keeps the others alive.
static inline void ffp_tile_configure(const FfpTileShapes *shapes) {
    __asm__ volatile("" : : "r"(shapes) : "memory");
    _tile_loadconfig(shapes);
}
#define ffp_tile_release() _tile_release()
#define ffp_tile_zero(tile) _tile_zero(tile)
#define ffp_tile_load(tile, from, row_bytes) _tile_loadd(tile, from, row_bytes)
#define ffp_tile_store(tile, to, row_bytes) _tile_stored(tile, to, row_bytes)
#define ffp_tile_multiply_add(c, a, b) _tile_dpbf16ps(c, a, b)
#else
static struct FfpEmulatedTiles {
    FfpTileShapes shapes;
    union {
        float sum[FFP_TILE_ROWS][FFP_TILE_BYTES / 4];
        uint16_t pair[FFP_TILE_ROWS][FFP_TILE_BYTES / 4][2];
        uint8_t row[FFP_TILE_ROWS][FFP_TILE_BYTES];
    } tile[FFP_TILES_COUNT];
} emulated;
#pragma omp threadprivate(emulated)

static inline void ffp_tile_configure(const FfpTileShapes *shapes) {
    memset(&emulated, 0, sizeof emulated);
    emulated.shapes = *shapes;
}
static inline void ffp_tile_release(void) {
    memset(&emulated, 0, sizeof emulated);
}
static inline void ffp_tile_zero(int tile) {
    memset(&emulated.tile[tile], 0, sizeof emulated.tile[tile]);
}
// Rows beyond the tile's own become zero.
static inline void ffp_tile_load(int tile, const void *from, size_t row_bytes) {
    ffp_tile_zero(tile);
    for (int r = 0; r < emulated.shapes.rows[tile]; r++)
        memcpy(emulated.tile[tile].row[r], (const uint8_t *)from + (size_t)r * row_bytes,
               emulated.shapes.row_bytes[tile]);
}
static inline void ffp_tile_store(int tile, void *to, size_t row_bytes) {
    for (int r = 0; r < emulated.shapes.rows[tile]; r++)
        memcpy((uint8_t *)to + (size_t)r * row_bytes, emulated.tile[tile].row[r],
               emulated.shapes.row_bytes[tile]);
}

static inline float ffp_tile_widen(uint16_t number) {
    const uint32_t bits = (uint32_t)number << 16;
    float wide;
    memcpy(&wide, &bits, sizeof wide);
    return wide;
}
// Row k of tile b holds pair k of every column.
static inline void ffp_tile_multiply_add(int c, int a, int b) {
    for (int m = 0; m < emulated.shapes.rows[c]; m++)
        for (int k = 0; k < emulated.shapes.row_bytes[a] / 4; k++)
            for (int n = 0; n < emulated.shapes.row_bytes[c] / 4; n++)
                for (int i = 0; i < 2; i++)
                    emulated.tile[c].sum[m][n] += ffp_tile_widen(emulated.tile[a].pair[m][k][i]) *
                                                  ffp_tile_widen(emulated.tile[b].pair[k][n][i]);
}
#endif

#endif
