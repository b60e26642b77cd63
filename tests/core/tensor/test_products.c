// Matrix products of every CPU level that runs here, of random shapes, against sums in double.
// Labels: threads
#include <math.h>
#include <omp.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "core/base/cpu.h"
#include "core/tensor/random.h"
#include "core/tensor/tensor.h"
#include "support.h"

typedef struct Product {
    bool transpose_a, transpose_b;
    int m, n, k, lda, ldb, ldc;
    float alpha, beta;
    bool inside; // a parallel region
} Product;

typedef __typeof__(ffp_gemm) *Gemm;

static Product random_product(FfpRng *rng, int trial, uint32_t most) {
    Product p = {.transpose_a = trial & 1, .transpose_b = trial & 2, .inside = trial & 4};
    p.m = 1 + (int)ffp_rng_below(rng, most);
    p.n = 1 + (int)ffp_rng_below(rng, most);
    p.k = 1 + (int)ffp_rng_below(rng, most);
    p.lda = (p.transpose_a ? p.m : p.k) + (int)ffp_rng_below(rng, 5);
    p.ldb = (p.transpose_b ? p.k : p.n) + (int)ffp_rng_below(rng, 5);
    p.ldc = p.n + (int)ffp_rng_below(rng, 5);
    p.alpha = trial % 3 ? 1 : -0.7F;
    p.beta = trial % 4 ? 0.5F * (float)(trial % 4 - 1) : 0;
    return p;
}

typedef struct Work {
    Gemm gemm;
    const Product *p;
    const float *a, *b;
    float *c;
} Work;

static void run_once(void *argument, int64_t index) {
    const Work *w = argument;
    const Product *p = w->p;
    if (index > 0) return;
    const FfpFactor a = {w->a, p->m, p->k, p->lda, p->transpose_a};
    const FfpFactor b = {w->b, p->k, p->n, p->ldb, p->transpose_b};
    w->gemm(p->alpha, a, b, p->beta, w->c, p->ldc);
}

static void run(Gemm gemm, const Product *p, const float *a, const float *b, float *c) {
    Work work = {gemm, p, a, b, c};
    if (p->inside)
        ffp_parallel_for(2, 2, run_once, &work);
    else
        run_once(&work, 0);
}

// To the nearest number of 8 significant bits, of two equally near ones the even.
static double to_bf16(double x) {
    int exponent;
    const double fraction = frexp(x, &exponent); // in [0.5, 1)
    return ldexp(rint(ldexp(fraction, 8)), exponent - 8);
}
static double unchanged(double x) {
    return x;
}

// op(X) with its lines (rows of A, columns of B) one after another, rounded.
static double *lines_of(const float *x, bool contiguous, int lines, int k, int ld,
                        double (*rounded)(double)) {
    double *out = ffp_alloc((size_t)lines * (size_t)k, sizeof(double));
    for (int i = 0; i < lines; i++)
        for (int l = 0; l < k; l++)
            out[(size_t)i * (size_t)k + (size_t)l] =
                rounded((double)(contiguous ? x[(size_t)i * (size_t)ld + (size_t)l]
                                            : x[(size_t)l * (size_t)ld + (size_t)i]));
    return out;
}

// With operands rounded by `rounded`, |error| <= 2^-24 (k + 4) sum |a b| in any order of summation (Higham
// 2002, 3.5, with room for alpha and beta), plus `slack` sum |a b|.
static void check_result(const Product *p, const float *a, const float *b, const float *c,
                         const float *before, double (*rounded)(double), double slack) {
    double *rows = lines_of(a, !p->transpose_a, p->m, p->k, p->lda, rounded);
    double *columns = lines_of(b, p->transpose_b, p->n, p->k, p->ldb, rounded);
    for (int i = 0; i < p->m; i++) {
        for (int j = 0; j < p->n; j++) {
            const double *x = rows + (size_t)i * (size_t)p->k, *y = columns + (size_t)j * (size_t)p->k;
            const size_t at = (size_t)i * (size_t)p->ldc + (size_t)j;
            double sum = 0, size = 0;
            for (int l = 0; l < p->k; l++) sum += x[l] * y[l], size += fabs(x[l] * y[l]);
            const double kept = p->beta == 0 ? 0 : (double)p->beta * (double)before[at];
            const double scaled = fabs((double)p->alpha) * size;
            const double bound = 0x1p-24 * (p->k + 4) * (scaled + fabs(kept)) + slack * scaled + 1e-30;
            assert_true(fabs((double)c[at] - (double)p->alpha * sum - kept) <= bound); // false for NaN too
        }
    }
    ffp_free(rows), ffp_free(columns);
}

// With operands in bf16, each within 2^-8 of its own: the result is near that of rounded operands, and
// within (1 + 2^-8)^2 - 1 of the true one.
static void check_product(Gemm gemm, const Product *p, FfpRng *rng, bool bf16) {
    const size_t na = (size_t)p->lda * (size_t)(p->transpose_a ? p->k : p->m);
    const size_t nb = (size_t)p->ldb * (size_t)(p->transpose_b ? p->n : p->k);
    const size_t nc = (size_t)p->ldc * (size_t)p->m;
    float *a = random_reals(rng, na, 1, 0), *b = random_reals(rng, nb, 1, 0);
    float *before = random_reals(rng, nc, 1, 0), *c = ffp_alloc(nc, sizeof(float));
    for (size_t at = 0; at < nc && p->beta == 0; at++) before[at] = NAN; // must not be read
    memcpy(c, before, nc * sizeof(float));
    run(gemm, p, a, b, c);
    check_result(p, a, b, c, before, bf16 ? to_bf16 : unchanged, 0);
    if (bf16) check_result(p, a, b, c, before, unchanged, 0x1p-7 + 0x1p-16);
    for (size_t at = (size_t)p->n; at < nc; at += (size_t)p->ldc) // between the rows nothing is written
        assert_memory_equal(c + at, before + at, sizeof(float) * (size_t)(p->ldc - p->n));
    ffp_free(a), ffp_free(b), ffp_free(c), ffp_free(before);
}

static void check_shapes(Gemm gemm, bool bf16) {
    FfpRng rng = ffp_rng(11, 0);
    for (int trial = 0; trial < 64; trial++) {
        const Product p = random_product(&rng, trial, trial % 16 == 0 ? 200 : 70);
        check_product(gemm, &p, &rng, bf16);
    }
    // several runs of k, blocks of rows and threads
    for (int trial = 0; trial < 4; trial++) {
        const Product p = {.transpose_a = trial & 1,
                           .transpose_b = trial & 2,
                           .m = 301,
                           .n = 71,
                           .k = 1201,
                           .lda = 1203,
                           .ldb = 1201,
                           .ldc = 80,
                           .alpha = 1,
                           .beta = 1};
        check_product(gemm, &p, &rng, bf16);
    }
}

static void products(void **state) {
    (void)state;
    check_shapes(ffp_gemm, false);
}

static void mixed_products(void **state) {
    (void)state;
    const int threads = omp_get_max_threads();
    for (int level = 0; level < FFP_CPU_LEVELS; level++) {
        if (!ffp_cpu_set_level((FfpCpuLevel)level)) continue;
        printf("%s\n", ffp_cpu_name((FfpCpuLevel)level));
        for (int count = 1; count <= 3; count++) {
            omp_set_num_threads(count);
            check_shapes(ffp_gemm_mixed, ffp_cpu_bf16((FfpCpuLevel)level));
        }
    }
    omp_set_num_threads(threads);
    ffp_cpu_set_level(ffp_cpu_best());
}

// Without terms C is only scaled; without rows or columns nothing happens.
static void nothing_to_add(void **state) {
    (void)state;
    for (int level = 0; level < FFP_CPU_LEVELS; level++) {
        if (!ffp_cpu_set_level((FfpCpuLevel)level)) continue;
        float none[1] = {0}, c[4] = {1, 2, 3, 4};
        ffp_gemm_mixed(1, ffp_factor(none, 2, 0, 1), ffp_factor(none, 0, 2, 2), 0.5F, c, 2);
        ffp_gemm_mixed(1, ffp_factor(none, 0, 3, 3), ffp_factor(none, 3, 2, 2), 0, c, 2);
        ffp_gemm_mixed(1, ffp_factor(none, 2, 3, 3), ffp_factor(none, 3, 0, 1), 0, c, 2);
        assert_true(c[0] == 0.5F && c[1] == 1 && c[2] == 1.5F && c[3] == 2);
    }
    ffp_cpu_set_level(ffp_cpu_best());
}

// y = residual + x w^T in place and apart, and y = x w^T + bias, against the product of the same level.
static void sums_with_products(void **state) {
    (void)state;
    enum { ROWS = 131, IN = 77, OUT = 45 };
    FfpRng rng = ffp_rng(16, 0);
    float *x = random_reals(&rng, ROWS * IN, 1, 0), *w = random_reals(&rng, IN * OUT, 1, 0);
    float *added = random_reals(&rng, ROWS * OUT, 1, 0), *plain = ffp_alloc(ROWS * OUT, sizeof(float));
    float *y = ffp_alloc(ROWS * OUT, sizeof(float)), *in_place = ffp_alloc(ROWS * OUT, sizeof(float));
    for (int level = 0; level < FFP_CPU_LEVELS; level++) {
        if (!ffp_cpu_set_level((FfpCpuLevel)level)) continue;
        ffp_gemm_mixed(1, ffp_factor(x, ROWS, IN, IN), ffp_transposed(ffp_factor(w, OUT, IN, IN)), 0, plain,
                       OUT);
        ffp_linear_residual_forward(y, added, x, w, ROWS, IN, OUT);
        memcpy(in_place, added, ROWS * OUT * sizeof(float));
        ffp_linear_residual_forward(in_place, in_place, x, w, ROWS, IN, OUT);
        assert_memory_equal(y, in_place, ROWS * OUT * sizeof(float));
        for (int i = 0; i < ROWS * OUT; i++)
            assert_true(fabsf(y[i] - (plain[i] + added[i])) <= 1e-5F * (1 + fabsf(plain[i])));
        ffp_linear_forward(y, x, w, added, ROWS, IN, OUT);
        for (int i = 0; i < ROWS * OUT; i++)
            assert_true(fabsf(y[i] - (plain[i] + added[i % OUT])) <= 1e-5F * (1 + fabsf(plain[i])));
    }
    ffp_cpu_set_level(ffp_cpu_best());
    ffp_free(x), ffp_free(w), ffp_free(added), ffp_free(plain), ffp_free(y), ffp_free(in_place);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(products), cmocka_unit_test(mixed_products),
                                       cmocka_unit_test(nothing_to_add),
                                       cmocka_unit_test(sums_with_products)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
