// Labels: slow
// From the photographs of a generated scene, at three places of a camera, to a calibration without a board.
#include <ffprocams.h>
#include <math.h>
#include <stdlib.h>
#include "core/base/file.h"
#include "core/image/image.h"
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

// Photographs that hold linear light, of the first two places.
static void linear_photographs(void **state) {
    NEEDS_PHOTOGRAPHS();
    char places[2][2][FFP_PATH_MAX];
    FfpSelfCalibrationStats stats[3];
    FfpError err = {0};
    for (int i = 0; i < 2 * 99; i++) {
        char name[2][64], from[FFP_PATH_MAX];
        FfpImage image;
        snprintf(name[0], sizeof name[0], "shots/place-%02d", i / 99);
        snprintf(name[1], sizeof name[1], "linear/place-%02d", i / 99);
        assert_true(ffp_make_folders(in_scratch(name[1]), &err));
        for (int k = 0; k < 2; k++) snprintf(places[k][i / 99], FFP_PATH_MAX, "%s", in_scratch(name[k]));
        for (int k = 0; k < 2; k++) snprintf(name[k] + strlen(name[k]), 16, "/%03d.png", i % 99 + 1);
        snprintf(from, sizeof from, "%s", in_scratch(name[0]));
        if (!ffp_is_file(from)) continue;
        assert_true(ffp_image_read_over_black(&image, NULL, from, &err));
        assert_true(ffp_image_write_png16(&image, in_scratch(name[1]), &err));
        ffp_image_free(&image);
    }
    // As they were; the same light; and light taken for sRGB.
    for (int k = 0; k < 3; k++) {
        static const char *const folders[3] = {"of_srgb", "of_light", "of_values"};
        const char *const given[2] = {places[k > 0][0], places[k > 0][1]};
        FfpSelfCalibration o = options_for("shots", folders[k]);
        o.places = given, o.n_places = 2, o.linear = k == 1;
        if (!ffp_self_calibrate(NULL, &o, &stats[k], &err)) fail_msg("%s", err.text);
        printf("%s: %d points, rms %.5f\n", folders[k], stats[k].points, stats[k].rms);
    }
    const int points = stats[0].points; // some pixels lie at a limit, to the rounding of light
    assert_true(abs(stats[1].points - points) <= 5 && fabs(stats[1].rms - stats[0].rms) < 5e-3);
    assert_true(abs(stats[2].points - points) > 15);
}

// A place whose codes cannot be read is left out; one place alone is too little.
static void what_is_missing_is_said(void **state) {
    NEEDS_PHOTOGRAPHS();
    FfpError err = {0};
    FfpSelfCalibrationStats stats;
    FfpSelfCalibration o = options_for("shots/place-00", "one");
    assert_false(ffp_self_calibrate(NULL, &o, NULL, &err));
    printf("%s\n", err.text);
    assert_non_null(strstr(err.text, "1 of 1 places of the camera can be used, but 2 are needed"));
    assert_false(ffp_is_folder(in_scratch("one")));
    for (int all = 0; all <= 1; all++) { // some that are missing are made from the others
        for (int k = all ? 6 : 10; k < 20; k += all ? 1 : 3) {
            char name[64];
            snprintf(name, sizeof name, "shots/place-03/%03d.png", k);
            remove(in_scratch(name));
        }
        o = options_for("shots", all ? "three" : "four");
        if (!ffp_self_calibrate(NULL, &o, &stats, &err)) fail_msg("%s", err.text);
        assert_int_equal(stats.used, PLACES - all);
    }
    // A scene has no room around it.
    FfpGeneration g = ffp_generation_defaults();
    g.folder = in_scratch("room"), g.photographs = in_scratch("patterns"), g.rig = FFP_RIG_WALK, g.count = 1;
    g.room = true;
    assert_false(ffp_generate(NULL, &g, &err));
    assert_non_null(strstr(err.text, "whole scene"));
    o.length = -1;
    assert_false(ffp_self_calibrate(NULL, &o, NULL, &err));
    assert_string_equal(err.where, "length");
    o.length = 0, o.camera_per_folder = true, o.angles = (const double[]){0}, o.n_angles = 1;
    o.file = o.turntable_file = in_scratch("never.xml");
    assert_false(ffp_self_calibrate(NULL, &o, NULL, &err));
    assert_string_equal(err.where, "camera_per_folder");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_scene_calibrates_its_rig),
        cmocka_unit_test(linear_photographs),
        cmocka_unit_test(what_is_missing_is_said),
    };
    return cmocka_run_group_tests(tests, take_photographs, scratch_teardown);
}
