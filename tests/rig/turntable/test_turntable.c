// Turntables: where their stops are, and their files.
#include <math.h>
#include "core/base/call.h"
#include "core/base/rigid.h"
#include "rig/optics/matrix.h"
#include "rig/turntable/turntable.h"
#include "scratch.h"

static FfpCalibration calibration;
static FfpError err;

static void write_text(const char *name, const char *text) {
    assert_true(ffp_write_file(in_scratch(name), text, strlen(text), NULL));
}

// A camera and a projector beside it, both fixed.
static FfpCalibration fixed_rig(void) {
    return (FfpCalibration){.has_camera = true,
                            .has_projector = true,
                            .has_projector_pose = true,
                            .p2c = {1, 0, 0, -20, 0, 1, 0, 3, 0, 0, 1, 0, 0, 0, 0, 1}};
}

// A point fixed on the object stays where it is in the object's frame, wherever the table has turned it.
static void test_turntable(void **state) {
    (void)state;
    static FfpTurntable turntable;
    calibration = fixed_rig();
    const double angles[3] = {0, 30, 200};
    const FfpImportTurntable given = {
        .axis = {0.2, -1, 0.1}, .point = {3, 4, 50}, .angles = angles, .n_angles = 3};
    assert_true(ffp_turntable_take(&turntable, &given, &err));
    assert_true(ffp_turntable_apply(&turntable, &calibration, &err));
    assert_int_equal(calibration.n_stops, 3);
    assert_string_equal(calibration.stops[2].id, "200");
    const double *u = turntable.axis, start[3] = {7, -2, 45};
    double world[3][3];
    for (int k = 0; k < 3; k++) {
        // Rodrigues' formula again, with the cross product written out.
        const double a = turntable.angles[k] * acos(-1.0) / 180;
        double d[3], x[3], along = 0;
        for (int i = 0; i < 3; i++) d[i] = start[i] - turntable.point[i], along += u[i] * d[i];
        const double turn[3] = {u[1] * d[2] - u[2] * d[1], u[2] * d[0] - u[0] * d[2],
                                u[0] * d[1] - u[1] * d[0]};
        for (int i = 0; i < 3; i++)
            x[i] = turntable.point[i] + d[i] * cos(a) + turn[i] * sin(a) + u[i] * along * (1 - cos(a));
        const double *pose = calibration.stops[k].c2w;
        for (int i = 0; i < 3; i++)
            world[k][i] =
                pose[4 * i] * x[0] + pose[4 * i + 1] * x[1] + pose[4 * i + 2] * x[2] + pose[4 * i + 3];
    }
    for (int k = 1; k < 3; k++)
        for (int i = 0; i < 3; i++) assert_true(fabs(world[k][i] - world[0][i]) < 1e-9);
    // z is the axis, and the camera starts at y = 0, x > 0.
    assert_true(calibration.stops[0].c2w[3] > 40 && fabs(calibration.stops[0].c2w[7]) < 1e-9);
    ffp_calibration_free(&calibration);
}

// A turntable seen by two cameras gives both one world where its zero is known. `m`: first camera to second.
static void stops_of(FfpTurntable *turntable, const double m[16], double c2w[16]) {
    FfpTurntable seen = *turntable;
    calibration = fixed_rig();
    for (int i = 0; i < 3; i++) {
        seen.axis[i] = seen.zero[i] = 0, seen.point[i] = m[4 * i + 3];
        for (int k = 0; k < 3; k++) {
            seen.axis[i] += m[4 * i + k] * turntable->axis[k],
                seen.zero[i] += m[4 * i + k] * turntable->zero[k];
            seen.point[i] += m[4 * i + k] * turntable->point[k];
        }
    }
    assert_true(ffp_turntable_apply(&seen, &calibration, &err));
    memcpy(c2w, calibration.stops[1].c2w, 16 * sizeof *c2w);
    ffp_calibration_free(&calibration);
}

static void test_one_world(void **state) {
    (void)state;
    static FfpTurntable turntable;
    const double c = cos(0.4), s = sin(0.4);
    const double same[16] = {[0] = 1, [5] = 1, [10] = 1, [15] = 1},
                 moved[16] = {c, 0, s, -12, 0, 1, 0, 3, -s, 0, c, 5, 0, 0, 0, 1};
    double first[16], second[16], back[16];
    turntable = (FfpTurntable){.axis = {0, -1, 0},
                               .point = {3, 4, 50},
                               .zero = {0.6, 0, 0.8},
                               .clockwise = true,
                               .count = 2,
                               .angles = {0, 30}};
    stops_of(&turntable, same, first);
    stops_of(&turntable, moved, second);
    ffp_pose_product(second, moved, back); // what the first camera sees, by the second's world
    for (int i = 0; i < 16; i++) assert_true(fabs(back[i] - first[i]) < 1e-9);
    // Clockwise by 30 degrees is -30 about the axis.
    turntable.clockwise = false, turntable.angles[1] = -30;
    stops_of(&turntable, same, second);
    for (int i = 0; i < 16; i++) assert_true(fabs(second[i] - first[i]) < 1e-9);
}

#define NAMED "{\"axis\": [0,-1,0], \"point\": [0,0,9], \"views\": "

static void test_files_of_turntables(void **state) {
    (void)state;
    static FfpTurntable turntable;
    const double angles[2] = {0, 45};
    FfpImportTurntable given = {.file = in_scratch("table.json")};
    static const char *const wrong[][2] = {
        {"{\"axis\": [0,-1,0], \"point\": [0,0,9], \"clockwise\": 1}", "table.json: clockwise"},
        {"{\"axis\": [0,-1,0], \"point\": [0,0,9], \"zero\": [0,0,0]}", "table.json: zero"},
        {"{\"axis\": [0,-1,0], \"point\": [0,0,9], \"zero\": [1,0]}", "table.json: zero"},
        {NAMED "[\"a\", \"b\"], \"angles\": [0]}", "table.json: views"},
        {NAMED "[\"a\", \"a\"], \"angles\": [0, 9]}", "a second view 'a'"},
        {NAMED "[\"a\", \"b\"], \"left_out\": [\"c\"], \"angles\": [0, 9]}", "no view is called 'c'"},
        {NAMED "[\"a\", \"b\"], \"left_out\": [\"a\", \"b\"], \"angles\": [0, 9]}", "left_out"}};
    write_text("table.json",
               "{\"axis\": [0,-1,0], \"point\": [0,0,9], \"zero\": [1,0,0], \"clockwise\": true, "
               "\"board_angles\": [0, 15, 30]}");
    assert_false(ffp_turntable_take(&turntable, &given, &err));
    assert_non_null(strstr(err.text, "the file has no angles"));
    given.angles = angles, given.n_angles = 2;
    if (!ffp_turntable_take(&turntable, &given, &err)) fail_msg("%s", err.text);
    assert_true(turntable.clockwise && turntable.zero[0] == 1);
    assert_true(turntable.count == 2 && turntable.angles[1] == 45);
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        write_text("table.json", wrong[i][0]);
        assert_false(ffp_turntable_take(&turntable, &given, &err));
        if (!strstr(err.text, wrong[i][1])) fail_msg("'%s' is not in '%s'", wrong[i][1], err.text);
    }
}

static char told[64];

static void keep_code(void *user, const FfpFinding *finding) {
    (void)user;
    snprintf(told, sizeof told, "%s", finding->code);
}

static bool settle(void *given, FfpError *error) {
    return ffp_turntable_settle(given, &calibration, error);
}

// An axis in metres beside a rig in millimetres.
static void test_units(void **state) {
    (void)state;
    FfpContext context = {.settings = {.finding = keep_code}};
    const double angles[3] = {0, 30, 200};
    for (int metres = 0; metres < 2; metres++) {
        FfpImportTurntable given = {
            .axis = {0, -1, 0}, .point = {0, 0, metres ? 0.3 : 300}, .angles = angles, .n_angles = 3};
        calibration = fixed_rig();
        assert_true(ffp_call_run(&context, settle, &given, &err));
        assert_string_equal(told, metres ? "axis-unit" : "");
        ffp_calibration_free(&calibration);
    }
}

// Stops by their names; those that are left out keep their place in the count.
static void test_named_stops(void **state) {
    (void)state;
    static FfpTurntable turntable;
    const FfpImportTurntable given = {.file = in_scratch("table.json")};
    calibration = fixed_rig();
    write_text("table.json", NAMED "[\"left\", \"right\"], \"left_out\": [\"left\"], \"angles\": [0, 0.3]}");
    if (!ffp_turntable_take(&turntable, &given, &err)) fail_msg("%s", err.text);
    assert_true(ffp_turntable_apply(&turntable, &calibration, &err));
    assert_int_equal(calibration.n_stops, 2);
    assert_string_equal(calibration.stops[1].id, "right");
    assert_true(calibration.stops[0].left_out && !calibration.stops[1].left_out);
    ffp_calibration_free(&calibration);
    // Another object before the same rig has its own.
    const double angles[2] = {0, 45};
    calibration = fixed_rig();
    assert_true(ffp_turntable_take(
        &turntable, &(FfpImportTurntable){.file = given.file, .angles = angles, .n_angles = 2}, &err));
    assert_true(ffp_turntable_apply(&turntable, &calibration, &err));
    assert_string_equal(calibration.stops[1].id, "045");
    assert_false(calibration.stops[0].left_out);
    ffp_calibration_free(&calibration);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_turntable),           cmocka_unit_test(test_one_world),
        cmocka_unit_test(test_files_of_turntables), cmocka_unit_test(test_units),
        cmocka_unit_test(test_named_stops),
    };
    return cmocka_run_group_tests(tests, scratch_setup, scratch_teardown);
}
