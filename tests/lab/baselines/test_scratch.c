// Gaussians from scratch: points in the hull, densities, and a ball found.
#include <math.h>
#include "ball.h"
#include "engine/refine/fit.h"
#include "lab/baselines/scratch.h"
#include "support.h"

static void test_a_fit_from_scratch_finds_the_ball(void **state) {
    (void)state;
    FfpCapture c = ball_capture(400, 4, 40, 40, 32);
    FfpGaussians g;
    FfpScratchSettings s = ffp_scratch_defaults(false);
    FfpRefineResult result;
    FfpError err;
    s.points = 500, s.fit.steps = 200, s.density.from = 50, s.density.every = 50;
    assert_true(ffp_scratch_gaussians(&g, &c, &s, NULL));
    for (int64_t i = 0; i < g.count; i++) {
        const real *q = g.rotation + 4 * i;
        assert_true(ffp_dot3(g.centre + 3 * i, g.centre + 3 * i) < 0.8F);
        assert_true(fabsf(ffp_dot3(q, q) + q[3] * q[3] - 1) < 1e-5F);
    }
    ffp_gaussians_free(&g);
    assert_true(ffp_scratch_fit(&g, &c, ball_patterns, BALL_PATTERNS, &s, &result, NULL));
    assert_true(result.psnr_after > result.psnr_before + 4);
    assert_true(result.psnr_after > 20);
    assert_int_not_equal(result.gaussians, 500);
    ffp_gaussians_free(&g);
    memset(c.views[0].coverage.data, 0, sizeof(real) * 40 * 40);
    assert_false(ffp_scratch_gaussians(&g, &c, &s, &err));
    assert_non_null(strstr(err.text, "silhouettes"));
    ffp_capture_free(&c);
}

// The centres given are the points, however many and wherever they lie.
static void test_given_points_are_where_a_fit_begins(void **state) {
    (void)state;
    FfpCapture c = ball_capture(400, 4, 40, 40, 32);
    FfpGaussians points = ffp_gaussians_new(4), g;
    FfpScratchSettings s = ffp_scratch_defaults(true);
    FfpError err;
    for (int i = 0; i < 12; i++) points.centre[i] = (real)(i * i);
    s.given = &points;
    assert_true(ffp_scratch_gaussians(&g, &c, &s, NULL));
    assert_int_equal(g.count, 4);
    assert_memory_equal(g.centre, points.centre, 12 * sizeof(real));
    assert_true(g.scale[0] > 1);
    ffp_gaussians_free(&g);
    points.count = 3;
    assert_false(ffp_scratch_gaussians(&g, &c, &s, &err));
    assert_non_null(strstr(err.text, "3 points are too few"));
    points.count = 4;
    ffp_gaussians_free(&points);
    ffp_capture_free(&c);
}

// Clones, halves and removals, one of each.
static void test_density_doubles_and_removes(void **state) {
    (void)state;
    FfpGaussians g = ffp_gaussians_new(4);
    for (int64_t i = 0; i < 4; i++) {
        for (int k = 0; k < 3; k++) g.scale[3 * i + k] = i == 1 ? 0.2F : 0.01F, g.albedo[3 * i + k] = 0.5F;
        g.rotation[4 * i] = 1, g.opacity[i] = i == 2 ? 0.01F : 0.9F, g.roughness[i] = 0.5F;
        g.centre[3 * i] = (real)i;
    }
    const FfpScratchSettings s = ffp_scratch_defaults(false);
    FfpParameters p = ffp_parameters_new(&g, false, true);
    FfpGaussianAdam adam_state = ffp_gaussian_adam_new(&p, &s.fit);
    FfpDensityControl control = ffp_density_control_new(&s.density, 4, 1);
    const FfpGrowth growth = ffp_density_growth(&control);
    control.pull[0] = control.pull[1] = control.pull[2] = 1;
    control.seen[0] = control.seen[1] = control.seen[2] = control.seen[3] = 1;
    assert_false(growth.step(growth.state, s.density.from + 1, &p, &g, &adam_state));
    assert_true(growth.step(growth.state, s.density.from, &p, &g, &adam_state));
    assert_int_equal(p.numbers.count, 5); // 0, its clone, two halves of 1, 3
    assert_int_equal(adam_state.mean.count, 5);
    assert_float_equal(p.numbers.centre[0], p.numbers.centre[3], 0);
    assert_float_equal(exp(p.numbers.scale[6]), 0.125, 1e-6);
    assert_float_equal(exp(p.numbers.scale[9]), 0.125, 1e-6);
    assert_true(p.numbers.centre[6] != p.numbers.centre[9]);
    assert_float_equal(p.numbers.centre[12], 3, 0);
    ffp_density_control_free(&control);
    ffp_gaussian_adam_free(&adam_state);
    ffp_parameters_free(&p);
    ffp_gaussians_free(&g);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_a_fit_from_scratch_finds_the_ball),
                                       cmocka_unit_test(test_given_points_are_where_a_fit_begins),
                                       cmocka_unit_test(test_density_doubles_and_removes)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
