// Products of what the registers already hold: the most that a thread can multiply, to measure against.
#include "tensor/kernels/kernels.h"
#include "tensor/kernels/product.h"
#include "tensor/kernels/vector.h"

enum { ROUNDS = 1024 };

#ifdef FFP_TILES
#include "tensor/kernels/tiles.h"

double FFP_K(multiply_registers)(long repeats) {
    FfpTileShapes shapes = {.palette = 1};
    for (int tile = 0; tile < FFP_TILES_COUNT; tile++) {
        shapes.row_bytes[tile] = FFP_TILE_BYTES;
        shapes.rows[tile] = FFP_TILE_ROWS;
    }
    ffp_tile_configure(&shapes); // all tiles are zero
    for (long i = 0; i < repeats * ROUNDS; i++) {
        ffp_tile_multiply_add(0, 4, 6);
        ffp_tile_multiply_add(1, 4, 7);
        ffp_tile_multiply_add(2, 5, 6);
        ffp_tile_multiply_add(3, 5, 7);
    }
    ffp_tile_release();
    return (double)repeats * ROUNDS * 4 * 2 * 16 * 16 * 32;
}
#else
// As many chains as hide the latency: sums in registers, from which nothing can be taken out of the loop.
#ifdef FFP_BF16
enum { CHAINS = 12, OPERATIONS = 4 * FFP_LANES };
static inline FfpVector multiply_add(FfpVector sum, FfpVector x) {
    return (FfpVector)_mm512_dpbf16_ps((__m512)sum, (__m512bh)x, (__m512bh)x);
}
#else
enum { CHAINS = 12, OPERATIONS = 2 * FFP_LANES };
static inline FfpVector multiply_add(FfpVector sum, FfpVector x) {
    return sum * x + x;
}
#endif

double FFP_K(multiply_registers)(long repeats) {
    volatile real half = 0.5F;
    FfpVector sum[CHAINS], x = half + (FfpVector){0};
    for (int c = 0; c < CHAINS; c++) sum[c] = half + (FfpVector){0}; // equal, but the compiler cannot know
    for (long i = 0; i < repeats * ROUNDS; i++)
        for (int c = 0; c < CHAINS; c++) sum[c] = multiply_add(sum[c], x);
    for (int c = 1; c < CHAINS; c++) sum[0] += sum[c];
    half = sum[0][0]; // so that the sums are needed
    return (double)repeats * ROUNDS * CHAINS * OPERATIONS;
}
#endif
