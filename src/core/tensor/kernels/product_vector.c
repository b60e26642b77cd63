// Packed products with vector instructions: a block of C stays in registers while k runs.
#include "core/tensor/kernels/product.h"

#ifndef FFP_TILES
#include "core/tensor/kernels/exp2.h"
#include "core/tensor/kernels/vector.h"

// Rows and panels of a block: as many sums as leave registers for a panel of B and one number of A. Each sum
// is a chain of additions; there must be more of them than the latency of a multiplication times its
// throughput. 28 sums of 32 registers with AVX-512, 12 of 16 with AVX2 and SSE2; 20 of 32 with
// NEON, where five numbers of A stay in them, too (24 with bf16).
// Compilers of WebAssembly load all that they multiply into registers, of which x86 has 15 for them: 10 sums
// there, of half a panel.
enum { VECTORS = FFP_PACK_LINES / FFP_LANES }; // of one panel
#if defined(__AVX512F__)
enum { ROWS = FFP_PRODUCT_ROWS, PANELS = 2, WIDTH = PANELS * VECTORS };
#elif defined(__wasm_simd128__)
enum { ROWS = FFP_PRODUCT_ROWS, PANELS = 1, WIDTH = VECTORS / 2 };
#else
enum { ROWS = FFP_PRODUCT_ROWS, PANELS = 1, WIDTH = VECTORS };
#endif

typedef struct Block {
    const FfpPacked *a, *b;
    size_t a_depth, b_depth;
    int columns, groups; // groups: of k
    real alpha, beta;
    real *c;
    int ldc;
    FfpPacked *weights; // of product_weights, with rows this deep
    size_t depth;
    real *sums;
} Block;

// One group of k: of a row of A, the same for every lane, and of a vector of columns of B.
#if defined(FFP_BF16) && defined(__ARM_FEATURE_BF16_VECTOR_ARITHMETIC)
typedef bfloat16x8_t Number, Columns;
static inline Number load_number(const FfpPacked *a) {
    uint32_t pair;
    memcpy(&pair, a, sizeof pair);
    return vreinterpretq_bf16_u32(vdupq_n_u32(pair));
}
static inline Columns load_columns(const FfpPacked *b) {
    return vreinterpretq_bf16_u16(vld1q_u16(b));
}
static inline FfpVector multiply_add(FfpVector sum, Number a, Columns b) {
    return vbfdotq_f32(sum, a, b);
}
#elif defined(FFP_BF16)
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

// Sums of a row's vectors [first, first + count) go to C; `full`: all their columns exist.
static inline __attribute__((always_inline)) void store_row(const Block *block, int row, const FfpVector *sum,
                                                            int count, bool full) {
    real *c = block->c + (size_t)row * block->ldc;
    FFP_UNROLL(4)
    for (int v = 0; v < count; v++) {
        const int left = full ? FFP_LANES : block->columns - v * FFP_LANES;
        real *to = c + v * FFP_LANES;
        FfpVector value = sum[v] * block->alpha;
        if (block->beta != 0) value += block->beta * (full ? ffp_load(to) : ffp_load_masked(to, left));
        if (full)
            ffp_store(to, value);
        else
            ffp_store_masked(to, value, left);
    }
}

#ifdef FFP_PRODUCT_WEIGHTS
typedef uint32_t Bits __attribute__((vector_size(FFP_VECTOR_BYTES)));

// ffp_exp2_packed of numbers that are not below -125
static inline FfpVector raise(FfpVector x) {
    const FfpVector shifted = x + 12582912.0F, r = x - (shifted - 12582912.0F);
#ifdef FFP_BF16
    const FfpVector p = FFP_EXP2_SHORT(r);
#else
    const FfpVector p = FFP_EXP2_LONG(r);
#endif
    return (FfpVector)((Bits)p + ((Bits)shifted << 23));
}

// Sums of a row's vectors, as many as make whole panels, become weights.
static inline __attribute__((always_inline)) void weigh_row(const Block *block, int row, const FfpVector *sum,
                                                            int count) {
    FfpPacked *to = block->weights + (size_t)row * block->depth;
    real *sums = block->sums + (size_t)row * FFP_PACK_LINES;
    FfpVector all = ffp_load(sums), weight[WIDTH];
    FFP_UNROLL(4)
    for (int v = 0; v < count; v++) {
        weight[v] = raise(sum[v]);
        all += weight[v];
    }
    ffp_store(sums, all);
#if defined(FFP_BF16) && defined(__ARM_FEATURE_BF16_VECTOR_ARITHMETIC)
    FFP_UNROLL(4)
    for (int v = 0; v < count; v += 2)
        vst1q_u16(to + v * FFP_LANES,
                  vreinterpretq_u16_bf16(vcvtq_high_bf16_f32(vcvtq_low_bf16_f32(weight[v]), weight[v + 1])));
#elif defined(FFP_BF16)
    _mm512_storeu_si512(to, (__m512i)_mm512_cvtne2ps_pbh((__m512)weight[1], (__m512)weight[0]));
#else
    FFP_UNROLL(4)
    for (int v = 0; v < count; v++) ffp_store(to + v * FFP_LANES, weight[v]);
#endif
}
#else
static inline void weigh_row(const Block *block, int row, const FfpVector *sum, int count) {
    (void)block, (void)row, (void)sum, (void)count; // never called
}
#endif

// All loops over the block are unrolled, so that its sums never leave the registers.
static inline __attribute__((always_inline)) void add_up(const Block *block, int rows, int width,
                                                         FfpVector sum[ROWS][WIDTH]) {
    const FfpPacked *a = block->a, *b = block->b;
    const size_t b_panel = FFP_PACK_LINES * block->b_depth;
    FFP_UNROLL(16)
    for (int r = 0; r < rows; r++) {
        FFP_UNROLL(4)
        for (int v = 0; v < width; v++) sum[r][v] = (FfpVector){0};
    }
    for (int l = 0; l < block->groups; l++) {
        Columns columns[WIDTH];
        FFP_UNROLL(4)
        for (int v = 0; v < width; v++)
            columns[v] = load_columns(b + v / VECTORS * b_panel + v % VECTORS * FFP_LANES * FFP_PACK_GROUP);
        FFP_UNROLL(16)
        for (int r = 0; r < rows; r++) {
            const Number number = load_number(a + r * block->a_depth);
            FFP_UNROLL(4)
            for (int v = 0; v < width; v++) sum[r][v] = multiply_add(sum[r][v], number, columns[v]);
        }
        a += FFP_PACK_GROUP;
        b += FFP_PACK_GROUP * FFP_PACK_LINES;
    }
}

#if defined(FFP_BF16) && defined(__ARM_FEATURE_BF16_VECTOR_ARITHMETIC)
// The same for pairs of rows: bfmmla multiplies 2 x 4 by 4 x 2 numbers and adds to 2 x 2 sums, in the order
// in which bfdot would. Two groups of k are taken at once; zeros are packed after the last one.
static inline __attribute__((always_inline)) void add_up_pairs(const Block *block, int rows,
                                                               FfpVector sum[ROWS][WIDTH]) {
    const FfpPacked *a = block->a, *b = block->b;
    FfpVector squares[ROWS / 2][2 * WIDTH]; // two rows of two columns each
    FFP_UNROLL(16)
    for (int r = 0; r < rows / 2; r++) {
        FFP_UNROLL(8)
        for (int v = 0; v < 2 * WIDTH; v++) squares[r][v] = (FfpVector){0};
    }
    for (int l = 0; l < block->groups; l += 2) {
        bfloat16x8_t numbers[ROWS / 2];
        FFP_UNROLL(16)
        for (int r = 0; r < rows / 2; r++)
            numbers[r] = vreinterpretq_bf16_u16(vcombine_u16(vld1_u16(a + 2 * r * block->a_depth),
                                                             vld1_u16(a + (2 * r + 1) * block->a_depth)));
        FFP_UNROLL(4)
        for (int v = 0; v < WIDTH; v++) {
            const FfpPacked *from = b + v * FFP_LANES * FFP_PACK_GROUP;
            const uint32x4_t first = vreinterpretq_u32_u16(vld1q_u16(from));
            const uint32x4_t second =
                vreinterpretq_u32_u16(vld1q_u16(from + FFP_PACK_GROUP * FFP_PACK_LINES));
            const bfloat16x8_t low = vreinterpretq_bf16_u32(vzip1q_u32(first, second));
            const bfloat16x8_t high = vreinterpretq_bf16_u32(vzip2q_u32(first, second));
            FFP_UNROLL(16)
            for (int r = 0; r < rows / 2; r++) {
                squares[r][2 * v] = vbfmmlaq_f32(squares[r][2 * v], numbers[r], low);
                squares[r][2 * v + 1] = vbfmmlaq_f32(squares[r][2 * v + 1], numbers[r], high);
            }
        }
        a += 2 * FFP_PACK_GROUP;
        b += 2 * FFP_PACK_GROUP * FFP_PACK_LINES;
    }
    FFP_UNROLL(16)
    for (int r = 0; r < rows / 2; r++) {
        FFP_UNROLL(4)
        for (int v = 0; v < WIDTH; v++) {
            const float64x2_t left = vreinterpretq_f64_f32(squares[r][2 * v]);
            const float64x2_t right = vreinterpretq_f64_f32(squares[r][2 * v + 1]);
            sum[2 * r][v] = vreinterpretq_f32_f64(vzip1q_f64(left, right));
            sum[2 * r + 1][v] = vreinterpretq_f32_f64(vzip2q_f64(left, right));
        }
    }
}
#endif

#if defined(__ARM_NEON) && !defined(FFP_BF16) && !defined(FFP_REAL_DOUBLE)
#define FFP_LANE_PRODUCTS
// The same sums in the same order: fmla takes one lane of a vector, so a row's next four numbers are loaded
// at once. Zeros are packed after the last one.
static inline __attribute__((always_inline)) void add_up_lanes(const Block *block, int rows,
                                                               FfpVector sum[ROWS][WIDTH]) {
    const FfpPacked *a = block->a, *b = block->b;
    FFP_UNROLL(16)
    for (int r = 0; r < rows; r++) {
        FFP_UNROLL(4)
        for (int v = 0; v < WIDTH; v++) sum[r][v] = (FfpVector){0};
    }
#define ADD_LANE(i)                                                                                          \
    FFP_UNROLL(4)                                                                                            \
    for (int v = 0; v < WIDTH; v++) {                                                                        \
        const float32x4_t columns = vld1q_f32(b + ((i)*WIDTH + v) * FFP_LANES);                              \
        FFP_UNROLL(16)                                                                                       \
        for (int r = 0; r < rows; r++)                                                                       \
            sum[r][v] = (FfpVector)vfmaq_laneq_f32((float32x4_t)sum[r][v], columns, numbers[r], i);          \
    }
    for (int l = 0; l < block->groups; l += FFP_LANES) {
        float32x4_t numbers[ROWS];
        FFP_UNROLL(16)
        for (int r = 0; r < rows; r++) numbers[r] = vld1q_f32(a + r * block->a_depth);
        ADD_LANE(0)
        ADD_LANE(1)
        ADD_LANE(2)
        ADD_LANE(3)
        a += FFP_LANES;
        b += FFP_LANES * FFP_PACK_LINES;
    }
}
#endif

// Returns `rows`.
static inline __attribute__((always_inline)) int multiply(const Block *block, int rows, int panels,
                                                          bool weigh) {
    FfpVector sum[ROWS][WIDTH];
    const int width = panels < PANELS ? panels * VECTORS : WIDTH;
#ifdef FFP_LANE_PRODUCTS
    add_up_lanes(block, rows, sum);
#else
#if defined(FFP_BF16) && defined(__ARM_FEATURE_BF16_VECTOR_ARITHMETIC)
    if (rows % 2 == 0)
        add_up_pairs(block, rows, sum);
    else
#endif
        add_up(block, rows, width, sum);
#endif
    if (weigh) {
        FFP_UNROLL(16)
        for (int r = 0; r < rows; r++) weigh_row(block, r, sum[r], width);
    } else if (block->columns >= width * FFP_LANES) {
        FFP_UNROLL(16)
        for (int r = 0; r < rows; r++) store_row(block, r, sum[r], width, true);
    } else {
        FFP_UNROLL(16)
        for (int r = 0; r < rows; r++) store_row(block, r, sum[r], width, false);
    }
    return rows;
}

// As many of the rows as one block takes; returns how many.
static inline __attribute__((always_inline)) int multiply_rows(const Block *block, int rows, int panels,
                                                               bool weigh) {
    if (rows >= ROWS) return multiply(block, ROWS, panels, weigh);
    if (ROWS > 8 && rows >= 8) return multiply(block, 8 < ROWS ? 8 : ROWS, panels, weigh);
    if (ROWS > 4 && rows >= 4) return multiply(block, 4 < ROWS ? 4 : ROWS, panels, weigh);
    if (rows >= 2) return multiply(block, 2, panels, weigh);
    return multiply(block, 1, panels, weigh);
}

// Columns from `column` on, which begin a panel or lie within one.
static inline const FfpPacked *columns_from(const FfpOperand *b, int column) {
    const int within = column % FFP_PACK_LINES;
    return b->from + (size_t)(column - within) * b->depth + (size_t)within * FFP_PACK_GROUP;
}

// Panels of B outside, so that they stay in the first-level cache while the rows of A pass.
void ffp_product(int m, int n, int k, real alpha, FfpOperand a, FfpOperand b, real beta, real *c, int ldc) {
    Block block = {.a_depth = a.depth, .b_depth = b.depth, .alpha = alpha, .beta = beta, .ldc = ldc};
    block.groups = (k + FFP_PACK_GROUP - 1) / FFP_PACK_GROUP;
    for (int column = 0; column < n;) {
        const bool full = n - column > (PANELS - 1) * FFP_PACK_LINES;
        block.b = columns_from(&b, column);
        block.columns = n - column;
        for (int row = 0; row < m;) {
            block.a = a.from + (size_t)row * a.depth;
            block.c = c + (size_t)row * ldc + column;
            row += full ? multiply_rows(&block, m - row, PANELS, false)
                        : multiply_rows(&block, m - row, 1, false);
        }
        column += full ? WIDTH * FFP_LANES : FFP_PACK_LINES;
    }
}

#ifdef FFP_PRODUCT_WEIGHTS
void FFP_K(product_weights)(int m, int n, int k, FfpOperand a, FfpOperand b, FfpPacked *weights, real *sums) {
    Block block = {.a_depth = a.depth, .b_depth = b.depth, .depth = (size_t)n};
    block.groups = (k + FFP_PACK_GROUP - 1) / FFP_PACK_GROUP;
    for (int column = 0; column < n; column += WIDTH * FFP_LANES) {
        block.b = columns_from(&b, column);
        for (int row = 0; row < m;) {
            block.a = a.from + (size_t)row * a.depth;
            block.weights = weights + (size_t)row * block.depth + column;
            block.sums = sums + (size_t)row * FFP_PACK_LINES;
            row += multiply_rows(&block, m - row, PANELS, true);
        }
    }
}
#endif

#endif
