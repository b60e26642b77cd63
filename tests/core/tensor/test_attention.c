// Attention at every CPU level that this machine runs, against the plain double form.
// Labels: threads
#include <math.h>
#include <omp.h>
#include "core/base/alloc.h"
#include "core/base/cpu.h"
#include "core/tensor/kernels/exp2.h"
#include "core/tensor/naive_attention.h"
#include "core/tensor/random.h"
#include "core/tensor/tensor.h"
#include "support.h"

typedef struct Case {
    int rows, heads, dim;
    size_t count; // rows * heads * dim
    float *qkv, *q_gain, *k_gain, *dout;
} Case;

typedef struct Result {
    float *out, *log_sum, *dqkv, *dq_gain, *dk_gain;
} Result;

static Case new_case(uint64_t seed, int rows, int heads, int dim, double gain) {
    FfpRng rng = ffp_rng(14, seed);
    const size_t count = (size_t)rows * (size_t)heads * (size_t)dim;
    return (Case){rows,
                  heads,
                  dim,
                  count,
                  random_reals(&rng, 3 * count, 1, 0),
                  random_reals(&rng, (size_t)dim, 0.1 * gain, gain),
                  random_reals(&rng, (size_t)dim, 0.1, 1),
                  random_reals(&rng, count, 1, 0)};
}

static void free_case(Case *c) {
    ffp_free(c->qkv), ffp_free(c->q_gain), ffp_free(c->k_gain), ffp_free(c->dout);
}

// Both passes, the gains' gradients from zero, all scratch and outputs NaN before.
static Result run(const Case *c) {
    const FfpAttentionShape shape = {c->rows, c->heads, c->dim};
    const FfpAttentionInput in = {c->qkv, c->q_gain, c->k_gain};
    const size_t scratch_size = ffp_attention_scratch(&shape), dim = (size_t)c->dim;
    FfpRng rng = ffp_rng(0, 0);
    const double nan = (double)NAN;
    Result r = {random_reals(&rng, c->count, 0, nan), ffp_alloc((size_t)(c->rows * c->heads), sizeof(float)),
                random_reals(&rng, 3 * c->count, 0, nan), random_reals(&rng, dim, 0, 0),
                random_reals(&rng, dim, 0, 0)};
    float *scratch = random_reals(&rng, scratch_size, 0, nan);
    ffp_attention_forward(r.out, r.log_sum, &shape, &in, scratch);
    for (size_t i = 0; i < scratch_size; i++) scratch[i] = NAN; // nothing may be kept in between
    const FfpAttentionGradient grad = {r.dqkv, r.dq_gain, r.dk_gain};
    ffp_attention_backward(&grad, &shape, &in, r.out, r.log_sum, c->dout, scratch);
    ffp_free(scratch);
    return r;
}

static void free_result(Result *r) {
    ffp_free(r->out), ffp_free(r->log_sum), ffp_free(r->dqkv), ffp_free(r->dq_gain), ffp_free(r->dk_gain);
}

// |found - expected| / |expected| over rows of `width` that lie `stride` apart
static double relative_error(const float *found, const double *expected, size_t rows, size_t width,
                             size_t stride) {
    double error = 0, size = 0;
    for (size_t t = 0; t < rows; t++) {
        for (size_t i = 0; i < width; i++) {
            const double e = expected[t * stride + i], difference = (double)found[t * stride + i] - e;
            error += difference * difference, size += e * e;
        }
    }
    return sqrt(error / (size + 1e-20));
}

static void check_small(const char *name, double error, double bound) {
    if (!(error < bound)) print_error("%s: error %g, not below %g\n", name, error, bound);
    assert_true(error < bound); // false for NaN too
}

// Every operand of a product is off by a unit u at most: 2^-9 in bf16. An output is a mean of values with
// random errors of its two factors and of the score in the exponent. The score's error grows with the gains:
// a sum of 64 products of numbers of the gain's size, divided by 8. Gradients pass through two such products,
// those of the gains are differences of larger sums. In fp32 what counts is the rounding of the sums instead:
// a few hundred terms, 2^-21.
static void check_result(const Case *c, const Result *r, const NaiveAttention *n, FfpCpuLevel level,
                         double gain) {
    const size_t rows = (size_t)c->rows, width = (size_t)(c->heads * c->dim), dim = (size_t)c->dim;
    const double u = ffp_cpu_bf16(level) ? 0x1p-9 : 0x1p-21;
    check_small("out", relative_error(r->out, n->out, 1, c->count, c->count), (3 + gain / 2) * u);
    const char *names[] = {"dq", "dk", "dv"};
    for (size_t part = 0; part < 3; part++)
        check_small(names[part],
                    relative_error(r->dqkv + part * width, n->dqkv + part * width, rows, width, 3 * width),
                    (4 + gain) * u);
    check_small("q gain", relative_error(r->dq_gain, n->dq_gain, 1, dim, dim), 2 * (4 + gain) * u);
    check_small("k gain", relative_error(r->dk_gain, n->dk_gain, 1, dim, dim), 2 * (4 + gain) * u);
}

static void check_levels(Case c, double gain) {
    NaiveAttention n = naive_attention(c.dout, c.qkv, c.q_gain, c.k_gain, c.rows, c.heads, c.dim);
    const FfpCpuLevel kept = ffp_cpu_level();
    for (FfpCpuLevel level = FFP_CPU_PORTABLE; level <= ffp_cpu_best(); level++) {
        assert_true(ffp_cpu_set_level(level));
        printf("%s, %d rows, %d heads of %d, gain %g\n", ffp_cpu_name(level), c.rows, c.heads, c.dim, gain);
        Result r = run(&c);
        check_result(&c, &r, &n, level, gain);
        free_result(&r);
    }
    assert_true(ffp_cpu_set_level(kept));
    free_naive_attention(&n);
    free_case(&c);
}

static void against_double(void **state) {
    (void)state;
    FfpRng rng = ffp_rng(15, 0);
    check_levels(new_case(0, 520, 2, 64, 1), 1);
    check_levels(new_case(1, 300, 1, 64, 3), 3);   // scores below 60 for certain: no running maximum
    check_levels(new_case(2, 300, 1, 64, 10), 10); // with one
    check_levels(new_case(3, 129, 1, 31, 1), 1);
    for (uint64_t trial = 0; trial < 12; trial++) {
        const int rows = 1 + (int)ffp_rng_below(&rng, 300), heads = 1 + (int)ffp_rng_below(&rng, 3);
        check_levels(new_case(4 + trial, rows, heads, 1 + (int)ffp_rng_below(&rng, 80), 1), 1);
    }
}

// q and k of +-1 reach the greatest score that the gains allow; neither path may overflow there. With a gain
// of 96 a softmax of scores up to 768 picks one key (or equal ones): exact whatever the rounding.
static void extremes(void **state) {
    (void)state;
    const float gains[] = {7.4375F, 7.5625F, 96}; // greatest scores 59.5, 60.5 and 768
    for (int trial = 0; trial < 3; trial++) {
        Case c = new_case(20, 300, 2, 64, 1);
        for (size_t i = 0; i < 3 * c.count; i++)
            if (i % 384 < 256) c.qkv[i] = c.qkv[i] < 0 ? -1 : 1;
        memcpy(c.qkv + 128, c.qkv, 64 * sizeof(float)); // the first row meets itself
        for (int i = 0; i < c.dim; i++) c.q_gain[i] = gains[trial], c.k_gain[i] = 1;
        check_levels(c, (double)gains[trial]);
    }
}

// No thread count changes a bit.
static void same_bits(void **state) {
    (void)state;
    Case c = new_case(30, 700, 3, 32, 1);
    const int threads = omp_get_max_threads();
    omp_set_num_threads(1);
    Result one = run(&c);
    for (int count = 2; count <= 5; count++) {
        omp_set_num_threads(count);
        Result many = run(&c);
        assert_memory_equal(one.out, many.out, c.count * sizeof(float));
        assert_memory_equal(one.log_sum, many.log_sum, (size_t)(c.rows * c.heads) * sizeof(float));
        assert_memory_equal(one.dqkv, many.dqkv, 3 * c.count * sizeof(float));
        assert_memory_equal(one.dq_gain, many.dq_gain, (size_t)c.dim * sizeof(float));
        assert_memory_equal(one.dk_gain, many.dk_gain, (size_t)c.dim * sizeof(float));
        free_result(&many);
    }
    omp_set_num_threads(threads);
    free_result(&one);
    free_case(&c);
}

static void powers_of_two(void **state) {
    (void)state;
    double worst = 0, worst_short = 0;
    for (double x = -125; x < 127; x += 1e-4) {
        const double expected = exp2((double)(float)x);
        worst = worse(worst, fabs((double)ffp_exp2_f32((float)x) - expected) / expected);
        worst_short = worse(worst_short, fabs((double)ffp_exp2_short((float)x) - expected) / expected);
    }
    printf("2^x: worst relative error %.2g, short %.2g\n", worst, worst_short);
    assert_true(worst < 2.5e-7 && worst_short < 7.6e-5);
    assert_true(ffp_exp2_f32(-1e30F) > 0 && ffp_exp2_f32(-1e30F) < 3e-38F);
    assert_true(ffp_exp2_short(-INFINITY) > 0 && ffp_exp2_short(-INFINITY) < 3e-38F);
    assert_true(isnan(ffp_exp2_f32(NAN)) && isnan(ffp_exp2_short(NAN)));
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(powers_of_two), cmocka_unit_test(against_double),
                                       cmocka_unit_test(extremes), cmocka_unit_test(same_bits)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
