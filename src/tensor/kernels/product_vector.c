// Packed products with vector instructions: a block of C stays in registers while k runs.
#include "tensor/kernels/product.h"

#ifndef FFP_TILES
#include "tensor/kernels/vector.h"

// Rows and panels of a block: as many sums as leave registers for a panel of B and one number of A. Each sum
// is a chain of additions; there must be more of them than the latency of a multiplication times its
// throughput. 28 sums of 32 registers with AVX-512, 12 of 16 with AVX2 and SSE2, 24 of 32 with NEON.
#ifdef __AVX512F__
enum { ROWS = FFP_PRODUCT_ROWS, PANELS = 2 };
#else
enum { ROWS = FFP_PRODUCT_ROWS, PANELS = 1 };
#endif
enum { VECTORS = FFP_PACK_LINES / FFP_LANES }; // of one panel

typedef struct Block {
    const FfpPacked *a, *b;
    size_t a_depth, b_depth;
    int columns, groups; // groups: of k
    real alpha, beta;
    real *c;
    int ldc;
} Block;

// One group of k: of a row of A, the same for every lane, and of a vector of columns of B.
#ifdef FFP_BF16
typedef __m512i Number, Columns;
static inline Number load_number(const FfpPacked *a) {
    int32_t pair;
    memcpy(&pair, a, sizeof pair);
    return _mm512_set1_epi32(pair);
}
static inline Columns load_columns(const FfpPacked *b) {
    return _mm512_loadu_si512(b);
}
static inline FfpVector multiply_add(FfpVector sum, Number a, Columns b) {
    return (FfpVector)_mm512_dpbf16_ps((__m512)sum, (__m512bh)a, (__m512bh)b);
}
#else
typedef real Number;
typedef FfpVector Columns;
static inline Number load_number(const FfpPacked *a) {
    return *a;
}
static inline Columns load_columns(const FfpPacked *b) {
    return ffp_load(b);
}
static inline FfpVector multiply_add(FfpVector sum, Number a, Columns b) {
    return sum + a * b;
}
#endif

static inline void store(const Block *block, int row, int column, FfpVector sum) {
    real *c = block->c + (size_t)row * block->ldc + column;
    const int count = block->columns - column;
    sum *= block->alpha;
    if (block->beta != 0) sum += block->beta * ffp_load_part(c, count);
    ffp_store_part(c, sum, count);
}

static inline __attribute__((always_inline)) void multiply(const Block *block, int rows, int panels) {
    enum { WIDTH = PANELS * VECTORS };
    FfpVector sum[ROWS][WIDTH] = {0};
    const FfpPacked *a = block->a, *b = block->b;
    const size_t b_panel = FFP_PACK_LINES * block->b_depth;
    for (int l = 0; l < block->groups; l++) {
        Columns columns[WIDTH];
        for (int p = 0; p < panels; p++)
            for (int v = 0; v < VECTORS; v++)
                columns[p * VECTORS + v] = load_columns(b + p * b_panel + v * FFP_LANES * FFP_PACK_GROUP);
        for (int r = 0; r < rows; r++) {
            const Number number = load_number(a + r * block->a_depth);
            for (int v = 0; v < panels * VECTORS; v++)
                sum[r][v] = multiply_add(sum[r][v], number, columns[v]);
        }
        a += FFP_PACK_GROUP;
        b += FFP_PACK_GROUP * FFP_PACK_LINES;
    }
    for (int r = 0; r < rows; r++)
        for (int v = 0; v < panels * VECTORS; v++) store(block, r, v * FFP_LANES, sum[r][v]);
}

// As many of the rows as one block takes; returns how many.
static inline __attribute__((always_inline)) int multiply_rows(const Block *block, int rows, int panels) {
    if (rows >= ROWS) return multiply(block, ROWS, panels), ROWS;
    if (ROWS > 8 && rows >= 8) return multiply(block, 8 < ROWS ? 8 : ROWS, panels), 8;
    if (ROWS > 4 && rows >= 4) return multiply(block, 4 < ROWS ? 4 : ROWS, panels), 4;
    if (rows >= 2) return multiply(block, 2, panels), 2;
    return multiply(block, 1, panels), 1;
}

// Panels of B outside, so that they stay in the first-level cache while the rows of A pass.
void FFP_K(product)(int m, int n, int k, real alpha, const FfpPacked *a, size_t a_depth, const FfpPacked *b,
                    size_t b_depth, real beta, real *c, int ldc) {
    Block block = {.a_depth = a_depth, .b_depth = b_depth, .alpha = alpha, .beta = beta, .ldc = ldc};
    block.groups = (k + FFP_PACK_GROUP - 1) / FFP_PACK_GROUP;
    for (int column = 0; column < n;) {
        const bool full = n - column > (PANELS - 1) * FFP_PACK_LINES;
        block.b = b + (size_t)column * b_depth;
        block.columns = n - column;
        for (int row = 0; row < m;) {
            block.a = a + (size_t)row * a_depth;
            block.c = c + (size_t)row * ldc + column;
            row += full ? multiply_rows(&block, m - row, PANELS) : multiply_rows(&block, m - row, 1);
        }
        column += full ? PANELS * FFP_PACK_LINES : FFP_PACK_LINES;
    }
}

#endif
