// Packed products with Intel AMX: two tiles of A times two of B into four of C. The machines that this was
// written on have no AMX: a test runs the same lines with emulated tiles; the instructions themselves are
// untried.
#include "core/tensor/kernels/product.h"

#ifdef FFP_TILES
#include "core/base/integer.h"
#include "core/tensor/kernels/tiles.h"
#include "core/tensor/kernels/vector.h"

// Tiles 0 to 3 are C, row by row; 4 and 5 the rows of A; 6 and 7 the columns of B.
enum { ROWS = FFP_PRODUCT_ROWS, COLUMNS = 2 * FFP_PACK_LINES };

typedef struct Block {
    const FfpPacked *a, *b;
    size_t a_depth, b_depth;
    int rows, columns, k;
    real alpha, beta;
    real *c;
    int ldc;
} Block;

// Tiles of fewer rows at the lower edge of C, where A may end. The upper tiles of C and A have at least one.
static void configure(int rows) {
    FfpTileShapes shapes = {.palette = 1};
    const int upper = rows < FFP_TILE_ROWS ? rows : FFP_TILE_ROWS;
    const int lower = rows - upper < 1 ? 1 : rows - upper;
    const int tile_rows[FFP_TILES_COUNT] = {upper, upper, lower,         lower,
                                            upper, lower, FFP_TILE_ROWS, FFP_TILE_ROWS};
    for (int tile = 0; tile < FFP_TILES_COUNT; tile++) {
        shapes.row_bytes[tile] = FFP_TILE_BYTES;
        shapes.rows[tile] = (uint8_t)tile_rows[tile];
    }
    ffp_tile_configure(&shapes);
}

// sum = A B, rows of COLUMNS numbers; at the edges only what exists is read, and the rest is not set.
static void multiply(real *sum, const Block *block) {
    const size_t a_row = block->a_depth * sizeof(FfpPacked), b_row = FFP_TILE_BYTES;
    const bool lower = block->rows > FFP_TILE_ROWS, right = block->columns > FFP_PACK_LINES;
    ffp_tile_zero(0);
    ffp_tile_zero(1);
    ffp_tile_zero(2);
    ffp_tile_zero(3);
    for (int k = 0; k < block->k; k += FFP_PACK_DEPTH) {
        const FfpPacked *a = block->a + k, *b = block->b + (size_t)k * FFP_PACK_LINES;
        ffp_tile_load(4, a, a_row);
        ffp_tile_load(6, b, b_row);
        ffp_tile_multiply_add(0, 4, 6);
        if (right) {
            ffp_tile_load(7, b + FFP_PACK_LINES * block->b_depth, b_row);
            ffp_tile_multiply_add(1, 4, 7);
        }
        if (!lower) continue;
        ffp_tile_load(5, a + FFP_TILE_ROWS * block->a_depth, a_row);
        ffp_tile_multiply_add(2, 5, 6);
        if (right) ffp_tile_multiply_add(3, 5, 7);
    }
    const size_t sum_row = COLUMNS * sizeof(real);
    ffp_tile_store(0, sum, sum_row);
    ffp_tile_store(1, sum + FFP_PACK_LINES, sum_row);
    ffp_tile_store(2, sum + FFP_TILE_ROWS * COLUMNS, sum_row);
    ffp_tile_store(3, sum + FFP_TILE_ROWS * COLUMNS + FFP_PACK_LINES, sum_row);
}

static void store(const Block *block, const real *sum) {
    for (int r = 0; r < block->rows; r++) {
        real *c = block->c + (size_t)r * block->ldc;
        for (int i = 0; i < block->columns; i += FFP_LANES) {
            const int count = block->columns - i;
            FfpVector out = block->alpha * ffp_load(sum + r * COLUMNS + i);
            if (block->beta != 0) out += block->beta * ffp_load_masked(c + i, count);
            ffp_store_masked(c + i, out, count);
        }
    }
}

// The tiles are configured again where the number of rows changes, which is at the last block only.
void ffp_product(int m, int n, int k, real alpha, FfpOperand a, FfpOperand b, real beta, real *c, int ldc) {
    _Alignas(FFP_TILE_BYTES) real sum[ROWS * COLUMNS] = {0};
    Block block = {.a_depth = a.depth, .b_depth = b.depth, .k = k, .alpha = alpha, .beta = beta, .ldc = ldc};
    for (int configured = 0, row = 0; row < m; row += ROWS) {
        block.rows = ffp_smaller(ROWS, m - row);
        block.a = a.from + (size_t)row * a.depth;
        if (block.rows != configured) configure(configured = block.rows);
        for (int column = 0; column < n; column += COLUMNS) {
            block.columns = ffp_smaller(COLUMNS, n - column);
            block.b = b.from + (size_t)column * b.depth;
            block.c = c + (size_t)row * ldc + column;
            multiply(sum, &block);
            store(&block, sum);
        }
    }
    ffp_tile_release();
}

#endif
