// `ffprocams calibrate`: wrong usage, and real photographs (kamino410/procam-calibration's sample) against
// what OpenCV's own script makes of them. They are not part of the project: without them that is skipped.
// Labels: slow
#include <math.h>
#include "core/base/rigid.h"
#include "product/cli/program.h"
#include "rig/optics/calibration.h"

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
        {"calibrate shots -o x.xml --board 9x6 --square 25 --angles 600x1", "512 angles in degrees"},
        {"calibrate shots -o x.xml --board 9x6 --square 25 --angles 8x0", "not '8x0'"},
        {"calibrate shots -o x.xml --board 9x6 --square 25 --angles 0x45", "not '0x45'"},
        {"calibrate shots -o x.xml --board 9x6 --square 25 --angles 0,45,", "not '0,45,'"},
        {"calibrate shots -o x.xml --board 9x6 --square 0x10", "not '0x10'"},
        {"calibrate shots -o x --camera-per-folder", "--without-board"},
        {"calibrate shots -o x --without-board --camera-per-folder --angles 8x45", "--angles"}};
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
    assert_non_null(strstr(run.err, "no photographs given"));
    run_program(&run, "calibrate nowhere -o x.xml --board 9x6 --square 25");
    assert_int_equal(run.status, 1);
    assert_non_null(strstr(run.err, "(nowhere)"));
    assert_false(ffp_is_file("x.xml"));
}

// A fault that all of them share is reported once, and names the panel's size that nobody gave.
static void the_same_is_told_once(void **state) {
    (void)state;
    char command[1024];
    if (without_opencv) skip();
    snprintf(
        command, sizeof command,
        "for i in 0 1 2 3; do mkdir -p %s/shots/pose_$i && cp '%s/data/sample/path_0_theta000_all_white.png' "
        "%s/shots/pose_$i/1.png || exit 1; done",
        scratch, FFP_SOURCE_DIR, scratch);
    assert_int_equal(system(command), 0);
    for (int given = 0; given < 2; given++) {
        run_format(&run, "calibrate %s/shots -o %s/x.xml --board 9x6 --square 25%s", scratch, scratch,
                   given ? " --projector 1280x800" : "");
        assert_int_equal(run.status, 1);
        const char *first = strstr(run.err, "all 4 attitudes: 1 photographs");
        assert_non_null(first);
        assert_null(strstr(first + strlen("all 4 attitudes: there"), "1 photographs"));
        assert_int_equal(!strstr(run.err, "no --projector given: assuming the default panel size, "
                                          "1920 x 1080"),
                         given);
    }
    run_format(&run, "calibrate %s/shots -o %s/x.xml --board 9x6 --square 25 --json", scratch, scratch);
    assert_int_equal(run.status, 1);
    assert_non_null(strstr(run.out, "\"code\": \"too-few-usable\""));
    // Two of them are of another kind.
    snprintf(command, sizeof command,
             "cd %s/shots && cp pose_1/1.png pose_1/2.png && cp pose_3/1.png pose_3/2.png", scratch);
    assert_int_equal(system(command), 0);
    run_format(&run, "calibrate %s/shots -o %s/x.xml --board 9x6 --square 25", scratch, scratch);
    assert_non_null(strstr(run.err, "(pose_0, pose_2: 1 photographs"));
    assert_non_null(strstr(run.err, "; pose_1, pose_3: 2 photographs"));
}

static void read_calibration(FfpCalibration *calibration, const char *path) {
    FfpError err = {0};
    if (!ffp_calibration_read(calibration, &path, 1, NULL, &err)) fail_msg("%s", err.text);
}

static double rotation_between(const double a[16], const double b[16]) {
    double ra[9], rb[9], d[9], v[3];
    for (int i = 0; i < 9; i++) ra[i] = a[4 * (i / 3) + i % 3], rb[i] = b[4 * (i / 3) + i % 3];
    ffp_rotation_difference(ra, rb, d);
    ffp_rotation_to_vector(d, v);
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
    assert_int_equal(run_format(&run,
                                "--events 1 calibrate %s -o %s --board 9x7 --square 75 --projector 1024x768",
                                sample, file),
                     0);
    assert_non_null(strstr(run.out, "5 of 5 attitudes"));
    const char *at = strstr(run.out, "rms ");
    assert_non_null(at);
    assert_true(atof(at + 4) < 0.2);
    assert_true(has_told(&run, "lens-terms-to-fix"));
    assert_non_null(strstr(run.err, " --fix camera.k3"));
    FfpCalibration found, known;
    read_calibration(&found, file);
    read_calibration(&known, reference);
    const double off[2] = {found.camera.fx / known.camera.fx - 1,
                           found.projector.fx / known.projector.fx - 1};
    printf("focal lengths off by %.2f and %.2f %%, turn by %.2f degrees\n", 100 * off[0], 100 * off[1],
           rotation_between(found.p2c, known.p2c));
    assert_true(fabs(off[0]) < 0.01 && fabs(off[1]) < 0.01 && rotation_between(found.p2c, known.p2c) < 0.5);
    assert_true(found.projector.width == 1024 && found.camera.height == 1024);
    ffp_calibration_free(&found), ffp_calibration_free(&known);
}

// The commands that a calibration prints run as they are typed: folders of one name in several places.
static void what_comes_next_runs(void **state) {
    (void)state;
    char text[2048];
    if (without_opencv) skip();
    assert_int_equal(run_format(&run, "patterns -o %s/given --projector 160x100", scratch), 0);
    run_format(&run,
               "generate %s/walk --photographs %s/given --rig walk --views 3 --split test --first 1 "
               "--resolution 120 --preset smoke",
               scratch, scratch);
    if (run.status != 0) skip(); // without Embree
    snprintf(text, sizeof text,
             "cd '%s' && for p in walk/place-*; do mkdir -p days/${p#*/} && mv $p days/${p#*/}/shots; done",
             scratch);
    assert_int_equal(system(text), 0);
    // Everything that was shown; codes alone; one of these lost, inverses before patterns.
    static const char *const changes[] = {
        "true", "rm -f days/*/shots/00[123]*",
        ("for s in days/*/shots; do i=0; for f in $s/*; do i=$((i+1)); n=$(((i-1)/2*2+2-(i-1)%2)); mv $f "
         "$s/r$(printf %02d $n).png; done; rm $s/r15.png; done")};
    for (size_t k = 0; k < sizeof changes / sizeof *changes; k++) {
        snprintf(text, sizeof text,
                 "set -e; cd '%s'; ffprocams() { '%s' \"$@\"; }; rm -rf next patterns capture; %s; "
                 "ffprocams calibrate days/*/shots --without-board --projector 160x100 -o next >said; "
                 "sed -n '/^ffprocams/p' said >next.sh; test $(wc -l <next.sh) = 2; . ./next.sh",
                 scratch, FFP_PROGRAM, changes[k]);
        assert_int_equal(system(text), 0);
        assert_int_equal(run_format(&run, "info %s/capture", scratch), 0);
        assert_non_null(strstr(run.out, "place-02: camera"));
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(wrong_usage), cmocka_unit_test(what_is_refused),
                                       cmocka_unit_test(the_same_is_told_once),
                                       cmocka_unit_test(what_comes_next_runs),
                                       cmocka_unit_test(real_photographs)};
    return cmocka_run_group_tests(tests, setup, scratch_teardown);
}
