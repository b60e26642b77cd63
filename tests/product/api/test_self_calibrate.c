// Labels: slow
// From the photographs of a generated scene, at three places of a camera, to a calibration without a board.
#include <ffprocams.h>
#include <math.h>
#include "core/base/file.h"
#include "rig/optics/calibration.h"
#include "scratch.h"

enum { PLACES = 4, HEIGHT = 120, PANEL_W = 160, PANEL_H = 100 };

// The photographs, and whether there is OpenCV to calibrate with.
static bool photographed, without_opencv;

static int take_photographs(void **state) {
    FfpError err = {0};
    if (scratch_setup(state) != 0) return -1;
    const char *nothing = "nothing";
    FfpSelfCalibration o = ffp_self_calibration_defaults();
    o.places = &nothing, o.n_places = 1, o.folder = in_scratch("none");
    without_opencv = !ffp_self_calibrate(NULL, &o, NULL, &err) && err.code == FFP_ERROR_UNSUPPORTED;
    FfpPatterns patterns = ffp_patterns_defaults();
    patterns.folder = in_scratch("patterns"), patterns.width = PANEL_W, patterns.height = PANEL_H;
    if (ffp_write_patterns(NULL, &patterns, &err) < 0) return -1;
    FfpGeneration g = ffp_generation_defaults();
    g.folder = in_scratch("shots"), g.photographs = in_scratch("patterns");
    g.rig = FFP_RIG_WALK, g.split = FFP_SPLIT_TEST, g.count = 1, g.first = 1, g.views = PLACES,
    g.resolution = HEIGHT;
    g.preset = FFP_PRESET_SMOKE;
    photographed = ffp_generate(NULL, &g, &err);
    if (!photographed) printf("skipped: %s\n", err.text); // without Embree
    return photographed || err.code == FFP_ERROR_UNSUPPORTED ? 0 : -1;
}

#define NEEDS_PHOTOGRAPHS()                                                                                  \
    (void)state;                                                                                             \
    if (!photographed || without_opencv) skip()

// Of the folder of all photographs, or of one in it; the paths stay.
static FfpSelfCalibration options_for(const char *shots, const char *folder) {
    static char paths[3][FFP_PATH_MAX];
    static const char *const places[] = {paths[0]};
    FfpSelfCalibration o = ffp_self_calibration_defaults();
    const char *const names[3] = {shots, "patterns", folder};
    for (int i = 0; i < 3; i++) snprintf(paths[i], sizeof paths[i], "%s", in_scratch(names[i]));
    o.places = places, o.n_places = 1, o.shown = paths[1], o.folder = paths[2];
    return o;
}

static FfpCalibration read_model(const char *name) {
    FfpCalibration calibration;
    FfpError err = {0};
    const char *file = in_scratch(name);
    if (!ffp_calibration_read(&calibration, &file, 1, "calib", &err)) fail_msg("%s", err.text);
    return calibration;
}

// Between the first two places, in the model's unit.
static double step_of(const FfpCalibration *c) {
    double square = 0;
    for (int k = 0; k < 3; k++) square += pow(c->stops[1].c2w[4 * k + 3] - c->stops[0].c2w[4 * k + 3], 2);
    return sqrt(square);
}

static void a_scene_calibrates_its_rig(void **state) {
    NEEDS_PHOTOGRAPHS();
    FfpSelfCalibration o = options_for("shots", "found");
    FfpSelfCalibrationStats stats;
    FfpError err = {0};
    FfpCalibration truth = read_model("shots/colmap");
    o.length = step_of(&truth);
    if (!ffp_self_calibrate(NULL, &o, &stats, &err)) fail_msg("%s", err.text);
    FfpCalibration found = read_model("found");
    printf("%d of %d places, %d points, rms %.3f; camera %.2f (true %.2f) +- %.2f %%, projector %.2f (%.2f) "
           "+- %.2f "
           "%%; %.1f degrees\n",
           stats.used, stats.places, stats.points, stats.rms, found.stops[0].camera.fx,
           truth.stops[0].camera.fx, 100 * stats.camera_uncertain, found.projector.fx, truth.projector.fx,
           100 * stats.projector_uncertain, stats.parallax);
    assert_int_equal(stats.used, PLACES);
    assert_int_equal(found.n_stops, PLACES);
    assert_true(fabs(found.stops[0].camera.fx / truth.stops[0].camera.fx - 1) < 0.01);
    assert_true(fabs(found.projector.fx / truth.projector.fx - 1) < 0.01);
    assert_float_equal(step_of(&found), o.length, 1e-6);
    assert_true(stats.rms < 0.2 && stats.parallax > 10);
    ffp_calibration_free(&found), ffp_calibration_free(&truth);
    // The folder is not filled twice.
    assert_false(ffp_self_calibrate(NULL, &o, NULL, &err));
    assert_int_equal(err.code, FFP_ERROR_FILE);
}

// A place whose codes cannot be read is left out; one place alone is too little.
static void what_is_missing_is_said(void **state) {
    NEEDS_PHOTOGRAPHS();
    FfpError err = {0};
    FfpSelfCalibrationStats stats;
    FfpSelfCalibration o = options_for("shots/place-00", "one");
    assert_false(ffp_self_calibrate(NULL, &o, NULL, &err));
    printf("%s\n", err.text);
    assert_non_null(strstr(err.text, "no two places"));
    assert_false(ffp_is_folder(in_scratch("one")));
    assert_int_equal(remove(in_scratch("shots/place-03/010.png")), 0);
    o = options_for("shots", "three");
    if (!ffp_self_calibrate(NULL, &o, &stats, &err)) fail_msg("%s", err.text);
    assert_int_equal(stats.used, PLACES - 1);
    // A scene has no room around it.
    FfpGeneration g = ffp_generation_defaults();
    g.folder = in_scratch("room"), g.photographs = in_scratch("patterns"), g.rig = FFP_RIG_WALK, g.count = 1;
    g.room = true;
    assert_false(ffp_generate(NULL, &g, &err));
    assert_non_null(strstr(err.text, "whole scene"));
    o.length = -1;
    assert_false(ffp_self_calibrate(NULL, &o, NULL, &err));
    assert_non_null(strstr(err.text, "length"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_scene_calibrates_its_rig),
        cmocka_unit_test(what_is_missing_is_said),
    };
    return cmocka_run_group_tests(tests, take_photographs, scratch_teardown);
}
