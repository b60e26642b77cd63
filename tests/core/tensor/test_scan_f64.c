// SSD scan in double: chunked against the plain recurrence,
// and gradients of every input and parameter, both directions.
#include "core/base/alloc.h"
#include "core/tensor/gradient.h"
#include "core/tensor/plain_scan.h"
#include "core/tensor/tensor.h"

typedef struct Scan {
    FfpScanShape shape;
    FfpScanInput in;
    real *row, *dt_raw, *dt_bias, *a_log, *d; // row [T, ld] holds x, B and C side by side
    real *y, *weights, *scratch;
    size_t count;
} Scan;

static double scan_loss(void *context) {
    Scan *s = context;
    ffp_scan_forward(s->y, &s->shape, &s->in, s->scratch);
    return dot_reals(s->y, s->weights, s->count);
}

static Scan make_scan(FfpScanShape shape) {
    FfpRng rng = ffp_rng(5, (uint64_t)shape.rows);
    const int width = shape.heads * shape.head_dim;
    const size_t rows = (size_t)shape.rows, heads = (size_t)shape.heads;
    Scan s = {.shape = shape, .count = rows * (size_t)width};
    s.in.ld = width + 2 * shape.state + 3;
    s.in.lddt = shape.heads + 2;
    s.row = random_reals(&rng, rows * (size_t)s.in.ld, 1, 0);
    s.dt_raw = random_reals(&rng, rows * (size_t)s.in.lddt, 1, 0);
    s.dt_bias = random_reals(&rng, heads, 0.5, -1);
    s.a_log = random_reals(&rng, heads, 0.7, 0);
    s.d = random_reals(&rng, heads, 0.5, 1);
    s.y = random_reals(&rng, s.count, 1, 0);
    s.weights = random_reals(&rng, s.count, 1, 0);
    s.scratch = random_reals(&rng, ffp_scan_scratch(&shape), 1, 0);
    s.in.x = s.row, s.in.b = s.row + width, s.in.c = s.row + width + shape.state;
    s.in.dt_raw = s.dt_raw, s.in.dt_bias = s.dt_bias, s.in.a_log = s.a_log, s.in.d = s.d;
    return s;
}

static void check_scan(FfpScanShape shape) {
    Scan s = make_scan(shape);
    FfpRng rng = ffp_rng(6, 0);
    const int width = shape.heads * shape.head_dim;
    const size_t rows = (size_t)shape.rows, heads = (size_t)shape.heads,
                 used = (size_t)(width + 2 * shape.state);
    const size_t ld = (size_t)s.in.ld, lddt = (size_t)s.in.lddt;
    real *plain = random_reals(&rng, s.count, 1, 0), *drow = random_reals(&rng, rows * ld, 0, 2);
    real *ddt = random_reals(&rng, rows * lddt, 0, 2), *dbias = random_reals(&rng, heads, 0, 2);
    real *da_log = random_reals(&rng, heads, 0, 2), *dd = random_reals(&rng, heads, 0, 2);
    printf("rows %d heads %d of %d, state %d, chunk %d%s\n", shape.rows, shape.heads, shape.head_dim,
           shape.state, shape.chunk, shape.reverse ? ", reversed" : "");
    scan_loss(&s);
    scan_forward_reference(plain, &shape, &s.in);
    for (size_t i = 0; i < s.count; i++) assert_true(fabs(plain[i] - s.y[i]) < 1e-11);

    const FfpScanGradient grad = {drow, drow + width, drow + width + shape.state, ddt, dbias, da_log, dd};
    for (size_t i = 0, n = ffp_scan_scratch(&shape); i < n; i++)
        s.scratch[i] = NAN; // nothing may be kept in between
    ffp_scan_backward(&grad, &shape, &s.in, s.weights, s.scratch);
    check_gradient("scan x, B, C", scan_loss, &s, s.row, drow, 0, rows, used, ld);
    check_gradient("scan dt", scan_loss, &s, s.dt_raw, ddt, 2, rows, heads, lddt);
    check_gradient("scan dt_bias", scan_loss, &s, s.dt_bias, dbias, 2, 1, heads, heads);
    check_gradient("scan D", scan_loss, &s, s.d, dd, 2, 1, heads, heads);
    if (shape.rows > 1) check_gradient("scan a_log", scan_loss, &s, s.a_log, da_log, 2, 1, heads, heads);
    for (size_t t = 0; t < rows; t++)
        for (size_t j = used; j < ld; j++) assert_true(drow[t * ld + j] == 2);
    real *all[] = {plain,    drow,      ddt,     dbias, da_log, dd,        s.row,
                   s.dt_raw, s.dt_bias, s.a_log, s.d,   s.y,    s.weights, s.scratch};
    for (size_t i = 0; i < sizeof(all) / sizeof(all[0]); i++) ffp_free(all[i]);
}

static void scan_gradients(void **state) {
    (void)state;
    for (int reverse = 0; reverse < 2; reverse++) {
        check_scan((FfpScanShape){
            .rows = 19, .heads = 3, .head_dim = 5, .state = 7, .chunk = 8, .reverse = reverse});
        check_scan((FfpScanShape){
            .rows = 16, .heads = 1, .head_dim = 4, .state = 3, .chunk = 8, .reverse = reverse});
        check_scan((FfpScanShape){
            .rows = 5, .heads = 2, .head_dim = 3, .state = 2, .chunk = 64, .reverse = reverse});
        check_scan(
            (FfpScanShape){.rows = 9, .heads = 5, .head_dim = 1, .state = 1, .chunk = 1, .reverse = reverse});
        check_scan(
            (FfpScanShape){.rows = 1, .heads = 1, .head_dim = 2, .state = 3, .chunk = 4, .reverse = reverse});
        check_scan((FfpScanShape){
            .rows = 6, .heads = 1, .head_dim = 17, .state = 19, .chunk = 4, .reverse = reverse});
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(scan_gradients)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
