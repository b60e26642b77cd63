// Normal equations, and the descent: a curved valley, a line with its covariance, outliers, and what cannot
// be told.
#include <math.h>
#include "core/base/rng.h"
#include "core/numerics/least_squares.h"
#include "support.h"

static void normal_equations_are_solved(void **state) {
    (void)state;
    double a[9] = {4, 0, 0, 1, 3, 0, -1, 0.5, 2}, x[3]; // the lower half counts
    const double b[3] = {1, -2, 0.5};
    const double full[9] = {4, 1, -1, 1, 3, 0.5, -1, 0.5, 2};
    assert_true(ffp_solve_positive(a, b, 3, x));
    for (int i = 0; i < 3; i++) {
        const double *row = full + 3 * i;
        assert_true(fabs(row[0] * x[0] + row[1] * x[1] + row[2] * x[2] + b[i]) < 1e-12);
    }
    double saddle[4] = {1, 0, 2, 1};
    assert_false(ffp_solve_positive(saddle, b, 2, x));
    assert_true(x[0] == 0 && x[1] == 0);
}

// Rosenbrock 1960: 100 (y - x^2)^2 + (1 - x)^2.
static void valley(const void *state, const double *by, double *out) {
    const double *at = state, x = at[0] + by[0], y = at[1] + by[1];
    out[0] = 10 * (y - x * x), out[1] = 1 - x;
}

static void valley_move(void *state, const double *by) {
    double *at = state;
    for (int k = 0; k < 2; k++) at[k] += by[k];
}

// The valley's, the other way round.
static void wrong_slopes(const void *state, double *out) {
    const double *at = state;
    const double right[4] = {-20 * at[0], -1, 10, 0};
    for (int i = 0; i < 4; i++) out[i] = -right[i];
}

static void a_curved_valley_is_walked_to_its_end(void **state) {
    (void)state;
    const double step[2] = {1e-6, 1e-6};
    double at[2] = {-1.2, 1};
    FfpFitEnd end;
    FfpLeastSquares problem = {.state = at,
                               .numbers = 2,
                               .count = 2,
                               .differences = valley,
                               .move = valley_move,
                               .step = step,
                               .steps = 100,
                               .worth = 1e-12,
                               .end = &end};
    assert_true(ffp_least_squares(&problem, NULL) < 1e-16);
    assert_true(fabs(at[0] - 1) < 1e-8 && fabs(at[1] - 1) < 1e-8);
    assert_int_equal(end, FFP_END_SETTLED);
    at[0] = -1.2, at[1] = 1, problem.steps = 1;
    const double cost = ffp_least_squares(&problem, NULL); // 24.2 at first
    assert_true(cost < 24.2 && cost > 1);
    assert_int_equal(end, FFP_END_UNFINISHED);
    at[0] = -1.2, at[1] = 1, problem.steps = 100, problem.slopes = wrong_slopes;
    ffp_least_squares(&problem, NULL);
    assert_int_equal(end, FFP_END_STUCK);
}

enum { POINTS = 200 };

// A line, and a number that moves nothing.
typedef struct Line {
    double value[3], x[POINTS], y[POINTS];
} Line;

static void line(const void *state, const double *by, double *out) {
    const Line *l = state;
    for (int i = 0; i < POINTS; i++) out[i] = l->value[0] + by[0] + (l->value[1] + by[1]) * l->x[i] - l->y[i];
}

static void line_move(void *state, const double *by) {
    Line *l = state;
    for (int k = 0; k < 2; k++) l->value[k] += by[k];
}

static Line line_new(double noise) {
    Line l = {{0}, {0}, {0}};
    FfpRng rng = ffp_rng(8, 0);
    for (int i = 0; i < POINTS; i++) {
        l.x[i] = (double)i / POINTS;
        l.y[i] = 2 - 3 * l.x[i] + noise * (double)ffp_rng_normal(&rng);
    }
    return l;
}

static const double line_step[3] = {1e-4, 1e-4, 1e-4};

static FfpLeastSquares line_fit(Line *l) {
    return (FfpLeastSquares){.state = l,
                             .numbers = 2,
                             .count = POINTS,
                             .differences = line,
                             .move = line_move,
                             .step = line_step,
                             .steps = 30,
                             .worth = 1e-12};
}

static void a_line_has_the_covariance_of_the_books(void **state) {
    (void)state;
    Line l = line_new(0.1);
    FfpLeastSquares problem = line_fit(&l);
    double covariance[9], x = 0, xx = 0, xy = 0, y = 0;
    const double variance = ffp_least_squares(&problem, covariance) / (POINTS - 2);
    for (int i = 0; i < POINTS; i++) x += l.x[i], y += l.y[i], xx += l.x[i] * l.x[i], xy += l.x[i] * l.y[i];
    const double determinant = POINTS * xx - x * x;
    assert_true(fabs(l.value[0] - (xx * y - x * xy) / determinant) < 1e-8);
    assert_true(fabs(l.value[1] - (POINTS * xy - x * y) / determinant) < 1e-8);
    assert_true(sqrt(variance) > 0.08 && sqrt(variance) < 0.12);
    const double expected[4] = {variance * xx / determinant, -variance * x / determinant,
                                -variance * x / determinant, variance * POINTS / determinant};
    for (int i = 0; i < 4; i++) assert_true(fabs(covariance[i] - expected[i]) < 1e-6 * fabs(expected[0]));
    const double before = covariance[0];
    problem.solved = POINTS / 2;
    ffp_least_squares(&problem, covariance);
    assert_true(fabs(covariance[0] / before - (POINTS - 2.0) / (POINTS / 2.0 - 2)) < 1e-6);
    problem.numbers = 3; // the third moves nothing
    ffp_least_squares(&problem, covariance);
    for (int i = 0; i < 9; i++) assert_true(isinf(covariance[i]));
}

// Geman and McClure's function of differences in units of 0.1; none where they are not finite.
static double robust(const void *state, const double *differences, double *weights) {
    (void)state;
    double sum = 0;
    for (int i = 0; i < POINTS; i++) {
        const double square = 100 * differences[i] * differences[i];
        weights[i] = isfinite(square) ? 1 / ((1 + square) * (1 + square)) : 0;
        sum += isfinite(square) ? square / (1 + square) : 1;
    }
    return sum;
}

static void weights_keep_outliers_out(void **state) {
    (void)state;
    Line plain = line_new(0.01);
    for (int i = 0; i < POINTS; i += 5) plain.y[i] += i % 2 ? 4 : NAN;
    Line held = plain;
    held.value[0] = 2.1, held.value[1] = -3.1;
    FfpLeastSquares problem = line_fit(&held);
    problem.weigh = robust;
    ffp_least_squares(&problem, NULL);
    assert_true(fabs(held.value[0] - 2) < 0.01 && fabs(held.value[1] + 3) < 0.01);
    for (int i = 0; i < POINTS; i++)
        if (isnan(plain.y[i])) plain.y[i] = 6;
    problem = line_fit(&plain);
    ffp_least_squares(&problem, NULL);
    assert_true(fabs(plain.value[0] - 2) > 0.1); // without weights they pull it away
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(normal_equations_are_solved),
                                       cmocka_unit_test(a_curved_valley_is_walked_to_its_end),
                                       cmocka_unit_test(a_line_has_the_covariance_of_the_books),
                                       cmocka_unit_test(weights_keep_outliers_out)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
