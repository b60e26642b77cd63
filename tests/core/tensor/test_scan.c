// The state-space scan at every CPU level that this machine runs, against the plain recurrence in double.
// Labels: threads
#include <math.h>
#include <omp.h>
#include "core/base/alloc.h"
#include "core/base/cpu.h"
#include "core/tensor/naive_scan.h"
#include "core/tensor/plain_scan.h"
#include "core/tensor/random.h"
#include "core/tensor/tensor.h"
#include "support.h"

typedef struct Case {
    FfpScanShape shape;
    size_t rows, heads, state, width, ld;
    float *row, *dt, *bias, *a_log, *d, *dy; // row [T, ld]: x, B, C
    FfpScanInput in;
} Case;

typedef struct Result {
    float *y, *drow, *ddt, *parameters; // parameters: dt_bias, a_log, d
    FfpScanGradient grad;
} Result;

// A, dt and the sizes as a network has them: A in 1..16, dt in 1e-3..1e-1 and beyond.
static Case new_case(FfpScanShape shape) {
    FfpRng rng = ffp_rng(12, (uint64_t)shape.rows);
    Case c = {.shape = shape,
              .rows = (size_t)shape.rows,
              .heads = (size_t)shape.heads,
              .state = (size_t)shape.state};
    c.width = c.heads * (size_t)shape.head_dim, c.ld = c.width + 2 * c.state;
    c.row = random_reals(&rng, c.rows * c.ld, 0.5, 0), c.dt = random_reals(&rng, c.rows * c.heads, 1, 0);
    c.bias = random_reals(&rng, c.heads, 1, -3), c.a_log = ffp_alloc(c.heads, sizeof(float));
    c.d = random_reals(&rng, c.heads, 0, 1), c.dy = random_reals(&rng, c.rows * c.width, 1, 0);
    for (size_t h = 0; h < c.heads; h++) c.a_log[h] = logf(1 + 15 * (float)h / (float)c.heads);
    c.in = (FfpScanInput){
        c.row, c.row + c.width, c.row + c.width + c.state, (int)c.ld, c.dt, (int)c.heads, c.bias, c.a_log,
        c.d};
    return c;
}

static void free_case(Case *c) {
    ffp_free(c->row), ffp_free(c->dt), ffp_free(c->bias), ffp_free(c->a_log), ffp_free(c->d), ffp_free(c->dy);
}

// Both passes; scratch and outputs are NaN before, sums zero.
static Result run(const Case *c) {
    const size_t scratch_size = ffp_scan_scratch(&c->shape);
    const double nan = (double)NAN;
    FfpRng rng = ffp_rng(0, 0);
    Result r = {.y = random_reals(&rng, c->rows * c->width, 0, nan),
                .drow = random_reals(&rng, c->rows * c->ld, 0, nan),
                .ddt = random_reals(&rng, c->rows * c->heads, 0, 0),
                .parameters = random_reals(&rng, 3 * c->heads, 0, 0)};
    float *scratch = random_reals(&rng, scratch_size, 0, nan);
    r.grad = (FfpScanGradient){r.drow,       r.drow + c->width,       r.drow + c->width + c->state, r.ddt,
                               r.parameters, r.parameters + c->heads, r.parameters + 2 * c->heads};
    ffp_scan_forward(r.y, &c->shape, &c->in, scratch);
    for (size_t i = 0; i < scratch_size; i++) scratch[i] = NAN; // nothing may be kept in between
    ffp_scan_backward(&r.grad, &c->shape, &c->in, c->dy, scratch);
    ffp_free(scratch);
    return r;
}

static void free_result(Result *r) {
    ffp_free(r->y), ffp_free(r->drow), ffp_free(r->ddt), ffp_free(r->parameters);
}

static double relative_error(const float *found, size_t ld, const double *expected, size_t rows,
                             size_t width) {
    double error = 0, size = 0;
    for (size_t t = 0; t < rows; t++) {
        for (size_t i = 0; i < width; i++) {
            const double e = expected[t * width + i], difference = (double)found[t * ld + i] - e;
            error += difference * difference, size += e * e;
        }
    }
    return sqrt(error / size);
}

// A sum over all rows whose terms have both signs may come out near zero: its error is measured by the terms.
static double sum_error(const float *found, const double *expected, const double *size, size_t count) {
    double worst = 0;
    for (size_t i = 0; i < count; i++) worst = worse(worst, fabs((double)found[i] - expected[i]) / size[i]);
    return worst;
}

static void check_small(const char *name, double error, double bound) {
    printf("  %-8s relative error %.2g\n", name, error);
    assert_true(error < bound); // false for NaN too
}

// Every operand of a product is off by 2^-9 at most in bf16, at random; an output passes through two products
// of two rounded operands each, gradients of dt through one more, and they are sums of terms of both signs.
// In fp32 what counts is the rounding of the sums and, in the exponents, of sums of steps.
static void check_result(const Case *c, const Result *r, const NaiveScan *n, bool bf16) {
    const double bound = bf16 ? 0x1p-7 : 2e-6, dt_bound = bf16 ? 0x1p-6 : 1e-5;
    check_small("y", relative_error(r->y, c->width, n->y, c->rows, c->width), bound);
    check_small("dx", relative_error(r->grad.x, c->ld, n->x, c->rows, c->width), bound);
    check_small("dB", relative_error(r->grad.b, c->ld, n->b, c->rows, c->state), bound);
    check_small("dC", relative_error(r->grad.c, c->ld, n->c, c->rows, c->state), bound);
    check_small("ddt", relative_error(r->ddt, c->heads, n->dt_raw, c->rows, c->heads), dt_bound);
    check_small("ddt_bias", sum_error(r->grad.dt_bias, n->dt_bias, n->bias_size, c->heads), dt_bound);
    check_small("da_log", sum_error(r->grad.a_log, n->a_log, n->a_log_size, c->heads), dt_bound);
    check_small("dD", relative_error(r->grad.d, c->heads, n->d, 1, c->heads), dt_bound);
}

static void check_levels(FfpScanShape shape) {
    Case c = new_case(shape);
    NaiveScan n = new_naive_scan(&shape);
    const FfpCpuLevel kept = ffp_cpu_level();
    float *plain = ffp_alloc(c.rows * c.width, sizeof(float));
    naive_scan(&n, &shape, &c.in, c.dy);
    scan_forward_reference(plain, &shape, &c.in);
    check_small("plain", relative_error(plain, c.width, n.y, c.rows, c.width), 2e-6);
    for (FfpCpuLevel level = FFP_CPU_PORTABLE; level <= ffp_cpu_best(); level++) {
        assert_true(ffp_cpu_set_level(level));
        printf("%s, %d rows, %d heads of %d, state %d, chunk %d%s\n", ffp_cpu_name(level), shape.rows,
               shape.heads, shape.head_dim, shape.state, shape.chunk, shape.reverse ? ", reversed" : "");
        Result r = run(&c);
        check_result(&c, &r, &n, ffp_cpu_bf16(level));
        free_result(&r);
    }
    assert_true(ffp_cpu_set_level(kept));
    free_naive_scan(&n);
    free_case(&c);
    ffp_free(plain);
}

static void against_double(void **state) {
    (void)state;
    FfpRng rng = ffp_rng(16, 0);
    for (int reverse = 0; reverse < 2; reverse++) {
        check_levels((FfpScanShape){500, 3, 64, 64, 64, reverse});
        check_levels((FfpScanShape){129, 1, 33, 17, 64, reverse});
        for (int trial = 0; trial < 4; trial++)
            check_levels((FfpScanShape){20 + (int)ffp_rng_below(&rng, 200), 1 + (int)ffp_rng_below(&rng, 4),
                                        4 + (int)ffp_rng_below(&rng, 40), 4 + (int)ffp_rng_below(&rng, 40),
                                        1 + (int)ffp_rng_below(&rng, 70), reverse});
    }
}

// Decays of e^-1000 a step and of none at all must neither overflow nor become NaN.
static void check_extremes(bool bf16) {
    Case c = new_case((FfpScanShape){70, 1, 8, 8, 32, false});
    double error = 0, size = 0;
    float *plain = ffp_alloc(c.rows * c.width, sizeof(float));
    for (size_t t = 0; t < c.rows; t++) c.dt[t] = t % 3 == 0 ? 60.0F : -120.0F;
    c.bias[0] = 0, c.a_log[0] = logf(16);
    Result r = run(&c);
    scan_forward_reference(plain, &c.shape, &c.in);
    for (size_t i = 0; i < c.rows * c.width; i++) {
        const double difference = (double)r.y[i] - (double)plain[i];
        error += difference * difference, size += (double)plain[i] * (double)plain[i];
    }
    check_small("y", sqrt(error / size), bf16 ? 0x1p-8 : 1e-6);
    for (size_t i = 0; i < c.rows * c.ld; i++) assert_true(isfinite(r.drow[i]));
    for (size_t t = 0; t < c.rows; t++) assert_true(isfinite(r.ddt[t]));
    for (int i = 0; i < 3; i++) assert_true(isfinite(r.parameters[i]));
    free_result(&r);
    free_case(&c);
    ffp_free(plain);
}

static void extremes(void **state) {
    (void)state;
    const FfpCpuLevel kept = ffp_cpu_level();
    for (FfpCpuLevel level = FFP_CPU_PORTABLE; level <= ffp_cpu_best(); level++) {
        assert_true(ffp_cpu_set_level(level));
        check_extremes(ffp_cpu_bf16(level));
    }
    assert_true(ffp_cpu_set_level(kept));
}

// No thread count changes a bit, more threads than chunks included.
static void same_bits(void **state) {
    (void)state;
    Case c = new_case((FfpScanShape){203, 3, 32, 16, 64, true});
    const int threads = omp_get_max_threads();
    omp_set_num_threads(1);
    Result one = run(&c);
    for (int count = 2; count <= 6; count++) {
        omp_set_num_threads(count);
        Result many = run(&c);
        assert_memory_equal(one.y, many.y, c.rows * c.width * sizeof(float));
        assert_memory_equal(one.drow, many.drow, c.rows * c.ld * sizeof(float));
        assert_memory_equal(one.ddt, many.ddt, c.rows * c.heads * sizeof(float));
        assert_memory_equal(one.parameters, many.parameters, 3 * c.heads * sizeof(float));
        free_result(&many);
    }
    omp_set_num_threads(threads);
    free_result(&one);
    free_case(&c);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(against_double), cmocka_unit_test(extremes),
                                       cmocka_unit_test(same_bits)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
