// How large a capture's pictures are where nobody says: as fine as the photographs show the object.
#include <stdlib.h>
#include <tgmath.h>
#include "core/base/alloc.h"
#include "rig/import/import_steps.h"
#include "scratch.h"

enum { WIDTH = 1600, HEIGHT = 1200 };

static char paths[2][FFP_PATH_MAX];

typedef struct Import {
    FfpImport settings;
    FfpStop stop;
    FfpView view;
    const char *pictures[FFP_PATTERNS_MAX];
    FfpImporting importing;
} Import;

// A disc at (x, y) in the dark, which white lights.
static void photograph(double x, double y, double radius) {
    FfpError err = {0};
    for (int p = 0; p < 2; p++) {
        FfpImage image = ffp_image_new(WIDTH, HEIGHT, 3);
        for (int i = 0; i < WIDTH * HEIGHT; i++) {
            const double u = i % WIDTH + 0.5 - x, v = i / WIDTH + 0.5 - y;
            const bool on = u * u + v * v < radius * radius;
            for (int c = 0; c < 3; c++) image.data[3 * i + c] = on ? (p ? 0.8F : 0.1F) : 0.02F;
        }
        if (!ffp_image_write_png(&image, paths[p], &err)) fail_msg("%s", err.text);
        ffp_image_free(&image);
    }
}

// The camera that the capture gets of these photographs.
static FfpCamera camera_for(int width, bool scene) {
    Import import = {.pictures = {paths[0], paths[1]}};
    import.settings = (FfpImport){.size = sizeof(FfpImport), .width = width, .scene = scene};
    import.stop.camera =
        (FfpOptics){.width = WIDTH, .height = HEIGHT, .fx = 1500, .fy = 1500, .cx = 820, .cy = 590};
    import.view.projector = (FfpCamera){.width = 64, .height = 64};
    ffp_optics_pinhole(&import.stop.camera, width, &import.view.camera);
    import.importing = (FfpImporting){.settings = &import.settings,
                                      .calibration = {.n_stops = 1, .stops = &import.stop},
                                      .shots = {.pictures = import.pictures, .n_patterns = 2, .white = 1},
                                      .capture = {
                                          .n_views = 1,
                                          .views = &import.view
                                      }};
    ffp_importing_fit_object(&import.importing);
    assert_null(import.view.images);
    assert_null(import.view.coverage.data);
    return import.view.camera;
}

static void a_small_object_is_cut_out_and_not_reduced(void **state) {
    (void)state;
    photograph(1000, 500, 150);
    const FfpCamera camera = camera_for(0, false);
    const double left = 820 - (double)camera.cx, top = 590 - (double)camera.cy;
    assert_float_equal(camera.fx, 1500, 1e-3);
    assert_true(left >= 1000 - 150 - 100 && left <= 1000 - 150 - 50); // with a quarter of its side around it
    assert_true(top >= 500 - 150 - 100 && top <= 500 - 150 - 50);
    assert_true(left + camera.width >= 1000 + 150 + 50 && left + camera.width <= 1000 + 150 + 100);
    assert_true(top + camera.height >= 500 + 150 + 50 && top + camera.height <= 500 + 150 + 100);
}

static void a_large_object_is_reduced(void **state) {
    (void)state;
    photograph(800, 600, 580);
    const FfpCamera camera = camera_for(0, false);
    const double scale = (double)camera.fx / 1500;
    assert_true(fabs(2 * 580 * scale - 1024) < 20); // it is looked for in pictures of 320 pixels
    assert_float_equal(camera.width, WIDTH * scale, 1);
    assert_float_equal(camera.height, HEIGHT * scale, 1);
    assert_float_equal(camera.cx, 820 * scale, 1);
}

static void a_width_that_was_given_holds(void **state) {
    (void)state;
    photograph(1000, 500, 150);
    const FfpCamera camera = camera_for(128, false);
    assert_int_equal(camera.width, 128);
    assert_int_equal(camera.height, 96);
}

static void without_an_object_it_is_the_frame(void **state) {
    (void)state;
    photograph(0, 0, 0);
    assert_int_equal(camera_for(0, false).width, 1024);
    photograph(1000, 500, 150);
    assert_int_equal(camera_for(0, true).width, 1024); // a whole scene
}

static int setup(void **state) {
    if (scratch_setup(state) != 0) return -1;
    snprintf(paths[0], sizeof paths[0], "%s", in_scratch("black.png"));
    snprintf(paths[1], sizeof paths[1], "%s", in_scratch("white.png"));
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_small_object_is_cut_out_and_not_reduced),
                                       cmocka_unit_test(a_large_object_is_reduced),
                                       cmocka_unit_test(a_width_that_was_given_holds),
                                       cmocka_unit_test(without_an_object_it_is_the_frame)};
    return cmocka_run_group_tests(tests, setup, scratch_teardown);
}
