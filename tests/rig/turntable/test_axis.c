// The turntable's axis found from photographs alone: a rendered object whose axis is known, and what must be
// refused.
// Labels: slow
#include <math.h>
#include "core/base/alloc.h"
#include "core/image/lookup.h"
#include "named.h"
#include "rig/optics/matrix.h"
#include "rig/turntable/fit_axis.h"
#include "rig/turntable/turntable.h"

#define DEGREE (3.14159265358979323846 / 180)

static FfpCapture capture;
static double p2c[16], angles[FFP_VIEWS_MAX];
static FfpAxis truth; // the world's z axis before the first camera
static FfpAxis found;
static FfpAxisReport report;
static FfpError err;

static int setup(void **state) {
    (void)state;
    double c2w[16], p2w[16], w2c[16];
    if (!ffp_capture_read(&capture, FFP_SOURCE_DIR "/data/sample", NULL)) return 1;
    for (int i = 0; i < 16; i++) {
        c2w[i] = (double)capture.views[0].camera.pose[i];
        p2w[i] = (double)capture.views[0].projector.pose[i];
    }
    ffp_pose_inverse(c2w, w2c);
    ffp_pose_product(w2c, p2w, p2c);
    for (int i = 0; i < 3; i++) truth.direction[i] = w2c[4 * i + 2], truth.point[i] = w2c[4 * i + 3];
    // The sample's cameras go round by +45 degrees a view, so the object turns the other way.
    for (int v = 0; v < capture.n_views; v++) angles[v] = -45.0 * v;
    return 0;
}

static int teardown(void **state) {
    (void)state;
    ffp_capture_free(&capture);
    return 0;
}

static bool fit(const FfpAxis *guess) {
    const int active = ffp_capture_active_pattern(&capture, NULL, NULL);
    err.text[0] = 0;
    const bool ok = ffp_fit_axis(&found, &report, &capture, active, p2c, angles, guess, &err);
    printf("%s; tilt %.3f degrees, shift %.3f %%, error %.3f of %.3f, %d points\n", ok ? "found" : err.text,
           report.tilt, 100 * report.shift, report.error, report.chance, report.surface_points);
    return ok;
}

static void must_fail(const FfpAxis *guess, const char *what) {
    assert_false(fit(guess));
    assert_non_null(strstr(err.text, what));
    assert_non_null(strstr(err.text, "turntable.axis"));
}

static bool fit_call(void *guess, FfpError *out) {
    const bool ok = fit(guess);
    *out = err;
    return ok;
}

static void must_refuse_by(const FfpAxis *guess, FfpRuleId rule) {
    char said[4096];
    FfpAxis copy = *guess;
    err = must_refuse(fit_call, &copy, rule, said);
    must_be(&err, rule);
    assert_non_null(strstr(err.text, "turntable.axis"));
}

// Within 0.15 degrees and 0.2 % of the distance.
static void check_found(void) {
    double off[3], across[3];
    for (int i = 0; i < 3; i++) off[i] = found.point[i] - truth.point[i];
    ffp_cross(off, truth.direction, across);
    const double tilt = acos(fmin(1, ffp_dot(found.direction, truth.direction))) / DEGREE,
                 shift = sqrt(ffp_dot(across, across)) / sqrt(ffp_dot(truth.point, truth.point));
    printf("off by %.3f degrees, %.3f %%\n", tilt, 100 * shift);
    assert_true(tilt < 0.15 && shift < 0.002);
    assert_true(tilt < 4 * report.tilt && shift < 4 * report.shift); // it knows how wrong it is
}

static void test_without_guess(void **state) {
    (void)state;
    assert_true(fit(NULL));
    check_found();
    assert_false(report.reversed);
    assert_true(report.error < 0.65 * report.chance && report.surface_points > 2000);
}

static void test_with_guess(void **state) {
    (void)state;
    SAME_WAY_AGAIN();
    const FfpAxis guess = {{0.1, -1, 0.1}, {0.1, 0, 2.6}};
    assert_true(fit(&guess));
    check_found();
}

// Angles counted the other way round: the same axis, with a note.
static void test_reversed(void **state) {
    (void)state;
    SAME_WAY_AGAIN();
    for (int v = 0; v < capture.n_views; v++) angles[v] = 45.0 * v;
    const FfpAxis guess = {{0, 1, 0}, {0, 0, 2.9}};
    assert_true(fit(&guess));
    assert_false(report.reversed); // right-handed about the axis that points down
    for (int i = 0; i < 3; i++) found.direction[i] = -found.direction[i];
    check_found();
}

// Where camera and projector are one, the pattern says nothing about distances.
static void test_no_baseline(void **state) {
    (void)state;
    p2c[3] = p2c[7] = p2c[11] = 0;
    assert_false(fit(NULL));
    assert_non_null(strstr(err.text, "camera and projector are in the same place"));
    assert_non_null(strstr(err.text, "(T)"));
}

static void test_guess_through_the_camera(void **state) {
    (void)state;
    const FfpAxis guess = {{0, -1, 0}, {0, 0, 0}};
    must_fail(&guess, "passes through the camera");
}

static void test_too_few_angles(void **state) {
    (void)state;
    for (int v = 0; v < capture.n_views; v++) angles[v] = 360.0 * v + 45 * (v % 2);
    must_fail(NULL, "three different angles are needed, but only 2 given");
}

static void test_wrong_angles(void **state) {
    (void)state;
    SAME_WAY_AGAIN();
    for (int v = 0; v < capture.n_views; v++) angles[v] = -77.0 * v;
    must_refuse_by(&truth, FFP_RULE_OUTLINES_NO_AXIS);
}

static void test_empty_masks(void **state) {
    (void)state;
    for (int v = 0; v < capture.n_views; v++)
        for (int i = 0; i < 128 * 128; i++) capture.views[v].coverage.data[i] = 0;
    must_refuse_by(&truth, FFP_RULE_OUTLINES_FEW);
}

// The projected picture differs from the file.
static void test_wrong_pattern(void **state) {
    (void)state;
    SAME_WAY_AGAIN();
    const int active = ffp_capture_active_pattern(&capture, NULL, NULL);
    const int other = ffp_capture_find_pattern(&capture, "lollipop_3");
    const FfpImage kept = capture.patterns[active].image;
    capture.patterns[active].image = capture.patterns[other].image;
    capture.patterns[other].image = kept;
    must_refuse_by(&truth, FFP_RULE_DISTANCE_OPEN);
}

static void test_projector_elsewhere(void **state) {
    (void)state;
    SAME_WAY_AGAIN();
    double kept[16];
    memcpy(kept, p2c, sizeof kept);
    for (int i = 0; i < 3; i++) p2c[4 * i] = -p2c[4 * i], p2c[4 * i + 2] = -p2c[4 * i + 2];
    must_refuse_by(&truth, FFP_RULE_PROJECTOR_MISSES);
    memcpy(p2c, kept, sizeof kept);
}

// The ball's pixel: coverage, and light where the projector's beam arrives; the same at all stops.
static void draw_ball_pixel(int i, double radius, const double c2p[16], const FfpSummed *pattern,
                            int active) {
    const FfpCamera *camera = &capture.views[0].camera;
    double ray[3] = {(i % 128 + 0.5 - (double)camera->cx) / (double)camera->fx,
                     (i / 128 + 0.5 - (double)camera->cy) / (double)camera->fy, 1};
    ffp_unit(ray);
    const double along = ffp_dot(ray, truth.point), gap = sqrt(fmax(9 - along * along, 0)) - radius,
                 coverage = fmin(fmax(0.5 - gap * (double)camera->fx / 3, 0), 1),
                 t = along - sqrt(fmax(radius * radius - 9 + along * along, 0));
    double q[3];
    real ratio[3];
    for (int k = 0; k < 3; k++)
        q[k] = c2p[4 * k + 3] + t * (c2p[4 * k] * ray[0] + c2p[4 * k + 1] * ray[1] + c2p[4 * k + 2] * ray[2]);
    const FfpCamera *lamp = &capture.views[0].projector;
    ffp_lookup(pattern, lamp->cx + lamp->fx * (real)(q[0] / q[2]), lamp->cy + lamp->fy * (real)(q[1] / q[2]),
               6, 6, ratio);
    for (int v = 0; v < capture.n_views; v++) {
        const FfpView *view = &capture.views[v];
        view->coverage.data[i] = (real)coverage;
        for (int c = 0; c < 3; c++) {
            view->images[capture.black].data[3 * i + c] = (real)(0.1 * coverage);
            view->images[capture.white].data[3 * i + c] = (real)(0.8 * coverage);
            view->images[active].data[3 * i + c] = (real)((0.1 + 0.7 * (double)ratio[c]) * coverage);
        }
    }
}

// A ball on the axis looks the same about every line through its middle.
static void test_round_object(void **state) {
    (void)state;
    const int active = ffp_capture_active_pattern(&capture, NULL, NULL);
    FfpSummed pattern = ffp_summed_new(&capture.patterns[active].image);
    double c2p[16];
    ffp_pose_inverse(p2c, c2p);
    for (int i = 0; i < 128 * 128; i++) draw_ball_pixel(i, 0.7, c2p, &pattern, active);
    ffp_summed_free(&pattern);
    const FfpAxis guess = {{0.2, -0.95, 0.2}, {0, 0, 3}};
    must_refuse_by(&guess, FFP_RULE_AXIS_OPEN);
}

static bool find_call(void *guess, FfpError *out) {
    FfpImportTurntable given = {.guessed = true};
    FfpCalibration calibration = {.n_stops = capture.n_views};
    const FfpAxis *axis = guess;
    calibration.stops = ffp_alloc((size_t)capture.n_views, sizeof *calibration.stops);
    memcpy(given.axis, axis->direction, sizeof given.axis);
    memcpy(given.point, axis->point, sizeof given.point);
    memcpy(calibration.p2c, p2c, sizeof p2c);
    for (int v = 0; v < capture.n_views; v++) calibration.stops[v].angle = angles[v];
    const bool ok = ffp_turntable_find(&given, &calibration, &capture, out);
    ffp_free(calibration.stops);
    return ok;
}

// Holes in three masks: the axis is found by the others.
static void test_holes_in_masks(void **state) {
    (void)state;
    char said[4096];
    for (int v = 0; v < 6; v += 2)
        for (int y = 41; y < 80; y++)
            for (int x = 31; x < 60; x++) capture.views[v].coverage.data[128 * y + x] = 0;
    err = must_refuse(find_call, &truth, FFP_RULE_AXIS_CONTRADICTS, said);
    must_be(&err, FFP_RULE_AXIS_CONTRADICTS);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_without_guess, setup, teardown),
        cmocka_unit_test_setup_teardown(test_with_guess, setup, teardown),
        cmocka_unit_test_setup_teardown(test_reversed, setup, teardown),
        cmocka_unit_test_setup_teardown(test_no_baseline, setup, teardown),
        cmocka_unit_test_setup_teardown(test_guess_through_the_camera, setup, teardown),
        cmocka_unit_test_setup_teardown(test_too_few_angles, setup, teardown),
        cmocka_unit_test_setup_teardown(test_wrong_angles, setup, teardown),
        cmocka_unit_test_setup_teardown(test_empty_masks, setup, teardown),
        cmocka_unit_test_setup_teardown(test_wrong_pattern, setup, teardown),
        cmocka_unit_test_setup_teardown(test_projector_elsewhere, setup, teardown),
        cmocka_unit_test_setup_teardown(test_round_object, setup, teardown),
        cmocka_unit_test_setup_teardown(test_holes_in_masks, setup, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
