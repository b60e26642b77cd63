// `ffprocams calibrate`: wrong usage, and real photographs (kamino410/procam-calibration's sample) against
// what OpenCV's own script makes of them. They are not part of the project: without them that is skipped.
#include <math.h>
#include "cli/program.h"
#include "base/motion.h"
#include "rig/calibration.h"

static ProgramRun run;
static bool without_opencv;

static int setup(void **state) {
    if (scratch_setup(state) != 0) return 1;
    run_program(&run, "calibrate nowhere -o x.xml --board 9x6 --square 25");
    without_opencv = strstr(run.err, "install OpenCV") != NULL;
    if (without_opencv) printf("skipped: %s", run.err);
    return run.status != 1;
}

static void wrong_usage(void **state) {
    (void)state;
    static const char *const table[][2] = {
        {"calibrate shots -o x.xml --square 25", "--board"},
        {"calibrate shots -o x.xml --board 9x6", "--square"},
        {"calibrate shots -o x.xml --board nine --square 25", "columns x rows of corners"},
        {"calibrate shots -o x.xml --board 9x6 --square 25 --fix k4", "camera. or projector."},
        {"calibrate shots -o x.xml --board 9x6 --square 25 --angles 1,a", "12x30"},
        {"calibrate shots -o x.xml --board 9x6 --square 25 --angles 600x1", "512 degrees"}};
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        run_program(&run, table[i][0]);
        assert_int_equal(run.status, 2);
        if (!strstr(run.err, table[i][1])) fail_msg("no '%s' in: %s", table[i][1], run.err);
    }
}

static void what_is_refused(void **state) {
    (void)state;
    if (without_opencv) skip();
    run_program(&run, "calibrate -o x.xml --board 9x6 --square 25");
    assert_int_equal(run.status, 1);
    assert_non_null(strstr(run.err, "there are no photographs"));
    run_program(&run, "calibrate nowhere -o x.xml --board 9x6 --square 25");
    assert_int_equal(run.status, 1);
    assert_non_null(strstr(run.err, "(nowhere)"));
    assert_false(ffp_is_file("x.xml"));
}

static void read_calibration(FfpCalibration *calibration, const char *path) {
    FfpError err = {0};
    if (!ffp_calibration_read(calibration, &path, 1, NULL, &err)) fail_msg("%s", err.text);
}

static double turn_between(const double a[16], const double b[16]) {
    double ra[9], rb[9], d[9], v[3];
    for (int i = 0; i < 9; i++) ra[i] = a[4 * (i / 3) + i % 3], rb[i] = b[4 * (i / 3) + i % 3];
    ffp_turn_difference(ra, rb, d);
    ffp_turn_vector(d, v);
    return sqrt(ffp_dot(v, v)) * 180 / FFP_PI_DOUBLE;
}

// The reference keeps every corner as the search finds it, a curled edge of the paper with them, and is
// itself uncertain by 18 pixels of focal length (0.5 %) and 26 of the principal point (0.4 degrees).
static void real_photographs(void **state) {
    (void)state;
    char sample[1024], reference[1100], file[256];
    if (without_opencv || !shared_path(sample, "real/kamino410/sample")) skip();
    snprintf(reference, sizeof reference, "%s/opencv_reference.xml", sample);
    snprintf(file, sizeof file, "%s/rig.xml", scratch);
    assert_int_equal(
        run_format(&run, "calibrate %s -o %s --board 9x7 --square 75 --projector 1024x768", sample, file), 0);
    assert_non_null(strstr(run.out, "5 of 5 attitudes"));
    const char *at = strstr(run.out, "rms ");
    assert_non_null(at);
    assert_true(atof(at + 4) < 0.2);
    assert_non_null(strstr(run.err, "do not determine the camera's k3"));
    FfpCalibration found, known;
    read_calibration(&found, file);
    read_calibration(&known, reference);
    const double off[2] = {found.camera.fx / known.camera.fx - 1,
                           found.projector.fx / known.projector.fx - 1};
    printf("focal lengths off by %.2f and %.2f %%, turn by %.2f degrees\n", 100 * off[0], 100 * off[1],
           turn_between(found.p2c, known.p2c));
    assert_true(fabs(off[0]) < 0.01 && fabs(off[1]) < 0.01 && turn_between(found.p2c, known.p2c) < 0.5);
    assert_true(found.projector.width == 1024 && found.camera.height == 1024);
    ffp_calibration_free(&found), ffp_calibration_free(&known);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(wrong_usage), cmocka_unit_test(what_is_refused),
                                       cmocka_unit_test(real_photographs)};
    return cmocka_run_group_tests(tests, setup, scratch_teardown);
}
