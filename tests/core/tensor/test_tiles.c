// The packed products of Intel AMX, with tiles emulated in plain C, so that they are tested on every machine:
// the kernels' own sources, compiled here as a level of their own.
#define FFP_LEVEL emulated
#define FFP_BF16
#define FFP_EMULATED_TILES
#include <math.h>
#include "core/base/alloc.h"
#include "core/tensor/kernels/pack.c"
#include "core/tensor/kernels/product_tiles.c"
#include "core/tensor/random.h"
#include "support.h"

static double widened(FfpPacked number) {
    return (double)ffp_tile_widen(number);
}

// Number l of column j of a packed B.
static double packed_number(const FfpPacked *b, int j, int l, size_t depth) {
    const FfpPacked *panel = ffp_packed_column(b, j / FFP_PACK_LINES * FFP_PACK_LINES, 0, depth);
    return widened(panel[(l / 2 * FFP_PACK_LINES + j % FFP_PACK_LINES) * 2 + l % 2]);
}

// Nearest number of 8 significant bits: within 2^-8 of the true one.
static void check_packing(const FfpPacked *a, const FfpPacked *b, const float *x, const float *y,
                          const int size[3], bool transpose_a, bool transpose_b, int lda, int ldb) {
    const int m = size[0], n = size[1], k = size[2], depth = (int)ffp_packed_depth(k);
    const int more = FFP_PACK_LINES;
    for (int l = 0; l < depth; l++) {
        for (int i = 0; i < (m + more - 1) / more * more; i++) {
            const float true_a = i >= m || l >= k ? 0 : transpose_a ? x[l * lda + i] : x[i * lda + l];
            const double found = widened(*(ffp_packed_row(a, i, 0, (size_t)depth) + l));
            assert_true(fabs(found - (double)true_a) <= 0x1p-8 * fabs((double)true_a));
        }
        for (int j = 0; j < (n + more - 1) / more * more; j++) {
            const float true_b = j >= n || l >= k ? 0 : transpose_b ? y[j * ldb + l] : y[l * ldb + j];
            const double found = packed_number(b, j, l, (size_t)depth);
            assert_true(fabs(found - (double)true_b) <= 0x1p-8 * fabs((double)true_b));
        }
    }
}

// C of the packed numbers themselves, in any order of summation (Higham 2002, 3.5).
static void check_c(const float *c, const float *before, const FfpPacked *a, const FfpPacked *b,
                    const int size[3], float alpha, float beta, int ldc) {
    const size_t depth = ffp_packed_depth(size[2]);
    for (int i = 0; i < size[0]; i++) {
        for (int j = 0; j < ldc; j++) {
            const double old = (double)before[i * ldc + j], found = (double)c[i * ldc + j];
            if (j >= size[1]) {
                assert_true(found == old); // between the rows nothing is written
                continue;
            }
            double sum = beta == 0 ? 0 : (double)beta * old, terms = fabs(sum);
            for (int l = 0; l < size[2]; l++) {
                const double product = (double)alpha * widened(*(ffp_packed_row(a, i, 0, depth) + l)) *
                                       packed_number(b, j, l, depth);
                sum += product, terms += fabs(product);
            }
            assert_true(fabs(found - sum) <= 0x1p-24 * (size[2] + 4) * terms + 1e-30);
        }
    }
}

static void check(FfpRng *rng, const int size[3], bool transpose_a, bool transpose_b, float alpha,
                  float beta) {
    const int m = size[0], n = size[1], k = size[2], ldc = n + 3;
    const int lda = (transpose_a ? m : k) + 1, ldb = (transpose_b ? k : n) + 2;
    float *x = random_reals(rng, (size_t)lda * (size_t)(transpose_a ? k : m), 1, 0);
    float *y = random_reals(rng, (size_t)ldb * (size_t)(transpose_b ? n : k), 1, 0);
    float *before = random_reals(rng, (size_t)m * (size_t)ldc, 1, 0);
    float *c = ffp_alloc((size_t)m * (size_t)ldc, sizeof *c);
    FfpPacked *a = ffp_alloc(ffp_packed_size(m, k), sizeof *a),
              *b = ffp_alloc(ffp_packed_size(n, k), sizeof *b);
    memset(a, 0xFF, ffp_packed_size(m, k) * sizeof *a);
    memset(b, 0xFF, ffp_packed_size(n, k) * sizeof *b);
    memcpy(c, before, (size_t)m * (size_t)ldc * sizeof *c);
    FFP_K(pack_rows)(a, transpose_a, m, k, x, lda);
    FFP_K(pack_columns)(b, transpose_b, k, n, y, ldb);
    check_packing(a, b, x, y, size, transpose_a, transpose_b, lda, ldb);
    ffp_product(m, n, k, alpha, ffp_operand(a, k), ffp_operand(b, k), beta, c, ldc);
    check_c(c, before, a, b, size, alpha, beta, ldc);
    ffp_free(x), ffp_free(y), ffp_free(before), ffp_free(c), ffp_free(a), ffp_free(b);
}

static void products(void **state) {
    (void)state;
    FfpRng rng = ffp_rng(17, 0);
    for (int trial = 0; trial < 64; trial++) {
        const int size[3] = {1 + (int)ffp_rng_below(&rng, 80), 1 + (int)ffp_rng_below(&rng, 80),
                             1 + (int)ffp_rng_below(&rng, 100)};
        check(&rng, size, trial & 1, trial & 2, trial % 3 ? 1 : -0.7F, (float)(trial % 4) / 2);
    }
}

// A product of the inner part of packed operands: rows 5.., columns 16.., k 32..
static void parts(void **state) {
    (void)state;
    enum { M = 37, N = 40, K = 96, ROW = 5, COLUMN = 16, FROM = 32, ROWS_HERE = 20, COLUMNS_HERE = 24 };
    FfpRng rng = ffp_rng(18, 0);
    float *x = random_reals(&rng, M * K, 1, 0), *y = random_reals(&rng, K * N, 1, 0),
          c[ROWS_HERE * COLUMNS_HERE];
    FfpPacked *a = ffp_alloc(ffp_packed_size(M, K), sizeof *a),
              *b = ffp_alloc(ffp_packed_size(N, K), sizeof *b);
    FFP_K(pack_rows)(a, false, M, K, x, K);
    FFP_K(pack_columns)(b, false, K, N, y, N);
    ffp_product(ROWS_HERE, COLUMNS_HERE, 32, 1, (FfpOperand){ffp_packed_row(a, ROW, FROM, K), K},
                (FfpOperand){ffp_packed_column(b, COLUMN, FROM, K), K}, 0, c, COLUMNS_HERE);
    for (int i = 0; i < ROWS_HERE; i++) {
        for (int j = 0; j < COLUMNS_HERE; j++) {
            double sum = 0, terms = 0;
            for (int l = FROM; l < FROM + 32; l++) {
                const double product =
                    widened(*(ffp_packed_row(a, ROW + i, 0, K) + l)) * packed_number(b, COLUMN + j, l, K);
                sum += product, terms += fabs(product);
            }
            assert_true(fabs((double)c[i * COLUMNS_HERE + j] - sum) <= 0x1p-24 * 36 * terms);
        }
    }
    ffp_free(x), ffp_free(y), ffp_free(a), ffp_free(b);
}

// Halves of the last place go to the even number, infinity and NaN stay.
static void rounding(void **state) {
    (void)state;
    const float numbers[32] = {1 + 0x1p-8F,  1 + 3 * 0x1p-8F, 1 + 0x1p-8F + 0x1p-20F,
                               -1 - 0x1p-8F, INFINITY,        -INFINITY,
                               NAN,          -0.0F,           0x1.FFFFFEp127F};
    const float expected[9] = {1,   1 + 4 * 0x1p-8F, 1 + 0x1p-7F, -1, INFINITY, -INFINITY,
                               NAN, -0.0F,           INFINITY};
    FfpPacked a[32 * FFP_PACK_LINES];
    FFP_K(pack_rows)(a, false, 1, 32, numbers, 32);
    for (int i = 0; i < 9; i++) {
        const float found = ffp_tile_widen(a[i]);
        if (isnan(expected[i]))
            assert_true(isnan(found));
        else
            assert_memory_equal(&found, &expected[i], sizeof found);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(products), cmocka_unit_test(parts),
                                       cmocka_unit_test(rounding)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
