// Packs operands for products. Both layouts and both ways an operand is stored meet in one square tile: as
// many lines as groups of k, loaded along a line or across the lines, turned over if the layout wants it.
#include "core/tensor/kernels/product.h"
#include "core/tensor/kernels/vector.h"

enum { TILE = FFP_LANES, TILE_DEPTH = TILE * FFP_PACK_GROUP };

// A cell is one group of k of one line.
#ifdef FFP_BF16
typedef uint32_t Cells __attribute__((vector_size(TILE * sizeof(uint32_t))));
#else
typedef FfpVector Cells;
#endif

typedef struct Source {
    const real *from;
    size_t stride;
    int lines, k;
} Source;

#if defined(FFP_BF16) && defined(__AVX512BF16__) && !defined(FFP_EMULATED_TILES)
// low, then high, as consecutive numbers
static inline Cells narrow_run(FfpVector low, FfpVector high) {
    return (Cells)_mm512_cvtne2ps_pbh((__m512)high, (__m512)low);
}
// Cell i holds even[i] and odd[i].
static inline Cells narrow_pairs(FfpVector even, FfpVector odd) {
    const __m512i low = _mm512_cvtepu16_epi32((__m256i)_mm512_cvtneps_pbh((__m512)even));
    const __m512i high = _mm512_cvtepu16_epi32((__m256i)_mm512_cvtneps_pbh((__m512)odd));
    return (Cells)_mm512_or_si512(low, _mm512_slli_epi32(high, 16));
}
#elif defined(FFP_BF16) && defined(__ARM_FEATURE_BF16_VECTOR_ARITHMETIC)
static inline Cells narrow_run(FfpVector low, FfpVector high) {
    return vreinterpretq_u32_bf16(vcvtq_high_bf16_f32(vcvtq_low_bf16_f32(low), high));
}
static inline Cells narrow_pairs(FfpVector even, FfpVector odd) {
    const uint16x8_t all = vreinterpretq_u16_u32(narrow_run(even, odd));
    return vreinterpretq_u32_u16(vzip1q_u16(all, vextq_u16(all, all, 4)));
}
#elif defined(FFP_BF16)
static inline uint32_t narrow(real x) {
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    if ((bits & 0x7FFFFFFF) > 0x7F800000) return bits >> 16 | 0x40; // NaN stays NaN
    return (bits + 0x7FFF + (bits >> 16 & 1)) >> 16;
}
static inline Cells narrow_run(FfpVector low, FfpVector high) {
    Cells cells = {0};
    for (int i = 0; i < 2 * TILE; i++)
        cells[i / 2] |= narrow(i < TILE ? low[i] : high[i - TILE]) << 16 * (i % 2);
    return cells;
}
static inline Cells narrow_pairs(FfpVector even, FfpVector odd) {
    Cells cells = {0};
    for (int i = 0; i < TILE; i++) cells[i] = narrow(even[i]) | narrow(odd[i]) << 16;
    return cells;
}
#endif

// A tile's width of groups of one line, from k on.
static inline Cells load_along(const Source *source, int line, int k) {
    const real *from = source->from + (size_t)line * source->stride + k;
    const int count = line < source->lines ? source->k - k : 0;
#ifdef FFP_BF16
    return narrow_run(ffp_load_masked(from, count), ffp_load_masked(from + TILE, count - TILE));
#else
    return ffp_load_masked(from, count);
#endif
}

// One group of a tile's width of lines.
static inline Cells load_across(const Source *source, int line, int k) {
    const real *from = source->from + (size_t)k * source->stride + line;
    const int count = source->lines - line;
#ifdef FFP_BF16
    return narrow_pairs(ffp_load_masked(from, k < source->k ? count : 0),
                        ffp_load_masked(from + source->stride, k + 1 < source->k ? count : 0));
#else
    return ffp_load_masked(from, k < source->k ? count : 0);
#endif
}

#if defined(__AVX512F__)
#define FIRST_HALVES 0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23
#define SECOND_HALVES 8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30, 15, 31
#elif defined(__AVX2__)
#define FIRST_HALVES 0, 8, 1, 9, 2, 10, 3, 11
#define SECOND_HALVES 4, 12, 5, 13, 6, 14, 7, 15
#elif !defined(FFP_REAL_DOUBLE)
#define FIRST_HALVES 0, 4, 1, 5
#define SECOND_HALVES 2, 6, 3, 7
#else
#define FIRST_HALVES 0, 2
#define SECOND_HALVES 1, 3
#endif

// Shuffling the rows of a 2^n square like two halves of a pack of cards, element by element, moves the top
// bit of the row number into the column number; n times turns the square over.
static inline __attribute__((always_inline)) void turn_over(Cells tile[TILE]) {
    for (int done = 1; done < TILE; done *= 2) {
        Cells next[TILE];
        for (int i = 0; i < TILE / 2; i++) {
            next[2 * i] = __builtin_shufflevector(tile[i], tile[i + TILE / 2], FIRST_HALVES);
            next[2 * i + 1] = __builtin_shufflevector(tile[i], tile[i + TILE / 2], SECOND_HALVES);
        }
        memcpy(tile, next, sizeof next);
    }
}

static inline __attribute__((always_inline)) void
pack_tile(FfpPacked *out, size_t depth, const Source *source, int line, int k, bool across, bool panels) {
    Cells tile[TILE];
    for (int i = 0; i < TILE; i++)
        tile[i] =
            across ? load_across(source, line, k + i * FFP_PACK_GROUP) : load_along(source, line + i, k);
    if (across != panels) turn_over(tile);
    out += panels ? (size_t)(line / FFP_PACK_LINES) * FFP_PACK_LINES * depth + (size_t)k * FFP_PACK_LINES +
                        (size_t)(line % FFP_PACK_LINES) * FFP_PACK_GROUP
                  : (size_t)line * depth + (size_t)k;
    const size_t step = panels ? FFP_PACK_LINES * FFP_PACK_GROUP : depth;
    for (int i = 0; i < TILE; i++) memcpy(out + i * step, &tile[i], sizeof tile[i]);
}

// The processor does not prefetch rows of memory that are far apart: this fetches those of the next tile.
static inline __attribute__((always_inline)) void fetch_across(const Source *source, int line, int k) {
    for (int i = 0; i < TILE_DEPTH; i++) {
        if (k + i >= source->k) return;
        __builtin_prefetch(source->from + (size_t)(k + i) * source->stride + line);
    }
}

// The innermost loop reads along the rows of memory.
static inline __attribute__((always_inline)) void pack(FfpPacked *out, const Source *source, bool across,
                                                       bool panels) {
    const int depth = (int)ffp_packed_depth(source->k);
    const int lines = (source->lines + FFP_PACK_LINES - 1) / FFP_PACK_LINES * FFP_PACK_LINES;
    if (across) {
        for (int k = 0; k < depth; k += TILE_DEPTH)
            for (int line = 0; line < lines; line += TILE) {
                if (line * (int)sizeof(real) % 64 == 0) fetch_across(source, line, k + TILE_DEPTH);
                pack_tile(out, (size_t)depth, source, line, k, true, panels);
            }
        return;
    }
    for (int line = 0; line < lines; line += TILE)
        for (int k = 0; k < depth; k += TILE_DEPTH)
            pack_tile(out, (size_t)depth, source, line, k, false, panels);
}

void FFP_K(pack_rows)(FfpPacked *out, bool transpose, int m, int k, const real *a, int lda) {
    const Source source = {.from = a, .stride = (size_t)lda, .lines = m, .k = k};
    if (transpose)
        pack(out, &source, true, false);
    else
        pack(out, &source, false, false);
}

void FFP_K(pack_columns)(FfpPacked *out, bool transpose, int k, int n, const real *b, int ldb) {
    const Source source = {.from = b, .stride = (size_t)ldb, .lines = n, .k = k};
    if (transpose)
        pack(out, &source, false, true);
    else
        pack(out, &source, true, true);
}
