// Products of packed operands: what linear layers, attention and the scan are built from. Inside the kernels
// folder only.
//
// A packed operand holds lines of `depth` numbers, depth being k rounded up to FFP_PACK_DEPTH with zeros. A's
// lines are the rows of A, one behind the other. B's lines are the columns of B, in panels of FFP_PACK_LINES:
// a panel holds, for every group of FFP_PACK_GROUP consecutive k, the group of its first column, of its
// second, and so on. The numbers are bf16 (rounded to nearest even) in groups of two where FFP_BF16 is set,
// and otherwise reals in groups of one. Part of a packed operand begins at ffp_packed_row or
// ffp_packed_column.
#ifndef FFP_TENSOR_KERNELS_PRODUCT_H
#define FFP_TENSOR_KERNELS_PRODUCT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include "core/base/level.h"
#include "core/base/real.h"

// Tiles: Intel's AMX, or the emulation of it that a test compiles.
#if defined(__AMX_BF16__) || defined(__AMXBF16__) || defined(FFP_EMULATED_TILES)
#define FFP_TILES
#endif

// Levels whose linear layers are made of these products; at the others they go to OpenBLAS, which looks at
// the processor itself and is faster than portable C.
#if defined(__AVX2__) || defined(__ARM_NEON) || defined(FFP_NO_BLAS)
#define FFP_OWN_PRODUCTS
#endif

#ifdef FFP_BF16
typedef uint16_t FfpPacked;
enum { FFP_PACK_GROUP = 2 };
#else
typedef real FfpPacked;
enum { FFP_PACK_GROUP = 1 };
#endif
enum { FFP_PACK_DEPTH = 32, FFP_PACK_LINES = 16 };

// Rows of C that ffp_product works on at once: fewer at the end of a call are less efficient.
#if defined(FFP_TILES)
enum { FFP_PRODUCT_ROWS = 32 };
#elif defined(__AVX512F__)
enum { FFP_PRODUCT_ROWS = 14 };
#elif defined(__AVX2__) || (defined(__ARM_NEON) && defined(FFP_BF16))
enum { FFP_PRODUCT_ROWS = 6 };
#elif defined(__ARM_NEON) || defined(__wasm_simd128__)
enum { FFP_PRODUCT_ROWS = 5 };
#else
enum { FFP_PRODUCT_ROWS = 3 };
#endif

static inline size_t ffp_packed_depth(int k) {
    return ((size_t)k + FFP_PACK_DEPTH - 1) / FFP_PACK_DEPTH * FFP_PACK_DEPTH;
}

// Numbers that an operand of `lines` lines takes; lines are rounded up to whole panels, filled with zeros.
static inline size_t ffp_packed_size(int lines, int k) {
    return ((size_t)lines + FFP_PACK_LINES - 1) / FFP_PACK_LINES * FFP_PACK_LINES * ffp_packed_depth(k);
}

// Where row i (any), or column j (a multiple of FFP_PACK_LINES), from its k-th number on (a multiple of
// FFP_PACK_DEPTH) begins.
static inline const FfpPacked *ffp_packed_row(const FfpPacked *packed, int i, int k, size_t depth) {
    return packed + (size_t)i * depth + (size_t)k;
}
static inline const FfpPacked *ffp_packed_column(const FfpPacked *packed, int j, int k, size_t depth) {
    return packed + (size_t)j * depth + (size_t)k * FFP_PACK_LINES;
}

// out = A [m,k], given as stored: a[i * lda + l], or a[l * lda + i] when `transpose`.
void FFP_K(pack_rows)(FfpPacked *out, bool transpose, int m, int k, const real *a, int lda);
// out = B [k,n], given as stored: b[l * ldb + j], or b[j * ldb + l] when `transpose`.
void FFP_K(pack_columns)(FfpPacked *out, bool transpose, int k, int n, const real *b, int ldb);

// A packed operand, or the part of it from some line and number on; `depth` is that of the whole.
typedef struct FfpOperand {
    const FfpPacked *from;
    size_t depth;
} FfpOperand;
static inline FfpOperand ffp_operand(const FfpPacked *packed, int k) {
    return (FfpOperand){packed, ffp_packed_depth(k)};
}

// C[m,n] = alpha A B + beta C on the caller's thread, C with row stride ldc; accumulated in real. A part that
// does not reach the end of k has a multiple of FFP_PACK_DEPTH as its k. With beta 0, C is not read.
#define ffp_product FFP_K(product)
void ffp_product(int m, int n, int k, real alpha, FfpOperand a, FfpOperand b, real beta, real *c, int ldc);

// Softmax weights straight from the sums in registers, where they are kept in vectors.
#if !defined(FFP_TILES) && !defined(FFP_REAL_DOUBLE)
#define FFP_PRODUCT_WEIGHTS
// weights[m,n] = 2^(A B), as packed rows of an operand that is n deep, n a multiple of FFP_PACK_DEPTH; no
// number of A B above 126 or below -125. sums[m, FFP_PACK_LINES] is ADDED to: a row's numbers together become
// greater by the sum of its weights before rounding.
void FFP_K(product_weights)(int m, int n, int k, FfpOperand a, FfpOperand b, FfpPacked *weights, real *sums);
#endif

#endif
