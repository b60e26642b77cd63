// A view's mask from photographs at more pixels than the capture has: when it is taken, and when the mask
// stays.
#include <stdlib.h>
#include "core/base/alloc.h"
#include "core/base/rng.h"
#include "rig/import/import_steps.h"
#include "scratch.h"

enum { WIDTH = 32, HEIGHT = 24, TIMES = 2 };

static const char *const names[] = {"black.png", "white.png", "grey.png"};
static char paths[3][FFP_PATH_MAX];

// A grey disc before a dark, noisy background.
static void photograph(const char *path, int times, double light) {
    FfpError err = {0};
    FfpImage image = ffp_image_new(times * WIDTH, times * HEIGHT, 3);
    FfpRng rng = ffp_rng(3, 1);
    for (int i = 0; i < image.width * image.height; i++) {
        const double x = (i % image.width + 0.5) / times - 15.3,
                     y = ((double)(i / image.width) + 0.5) / times - 12;
        const double value = (x * x + y * y < 36 ? light : 0.02) + 0.01 * (double)ffp_rng_uniform(&rng);
        for (int c = 0; c < 3; c++) image.data[3 * i + c] = (real)value;
    }
    if (!ffp_image_write_png(&image, path, &err)) fail_msg("%s", err.text);
    ffp_image_free(&image);
}

typedef struct Import {
    FfpImport settings;
    FfpStop stop;
    FfpView view;
    const char *pictures[FFP_PATTERNS_MAX];
    FfpImporting importing;
} Import;

// With a mask of the disc's own pixels, whose centre is `right` of where it is.
static void open_import(Import *import, int times, int right) {
    *import = (Import){.pictures = {paths[0], paths[1], paths[2]}};
    import->settings = (FfpImport){.size = sizeof(FfpImport)};
    import->stop.camera = (FfpOptics){.width = times * WIDTH,
                                      .height = times * HEIGHT,
                                      .fx = 40 * times,
                                      .fy = 40 * times,
                                      .cx = 16 * times,
                                      .cy = 12 * times};
    import->view.camera =
        (FfpCamera){.width = WIDTH, .height = HEIGHT, .fx = 40, .fy = 40, .cx = 16, .cy = 12};
    import->view.coverage = ffp_image_new(WIDTH, HEIGHT, 1);
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        const double x = i % WIDTH + 0.5 - 15.3 - right, y = (double)(i / WIDTH) + 0.5 - 12;
        import->view.coverage.data[i] = x * x + y * y < 36;
    }
    import->importing = (FfpImporting){.settings = &import->settings,
                                       .calibration = {.n_stops = 1, .stops = &import->stop},
                                       .shots = {.pictures = import->pictures, .n_patterns = 3, .white = 1},
                                       .capture = {
                                           .n_views = 1,
                                           .n_patterns = 3,
                                           .white = 1,
                                           .views = &import->view
                                       }};
}

// True if the mask was replaced; if not, it must be the same as before.
static bool refined(int times, int right) {
    Import import;
    open_import(&import, times, right);
    FfpImage before = ffp_image_copy(&import.view.coverage);
    const bool ok = ffp_importing_refine_mask(&import.importing, 0);
    int shares = 0;
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        const real share = import.view.coverage.data[i];
        shares += share > 0.1F && share < 0.9F;
        if (!ok) assert_true(share == before.data[i]);
    }
    assert_int_equal(shares > 20, ok); // along the outline
    assert_null(import.view.images);   // the finer photographs are gone
    ffp_image_free(&before), ffp_image_free(&import.view.coverage);
    return ok;
}

static int setup(void **state) {
    if (scratch_setup(state) != 0) return -1;
    for (int i = 0; i < 3; i++) snprintf(paths[i], sizeof paths[i], "%s", in_scratch(names[i]));
    return 0;
}

static void take_photographs(int times) {
    photograph(paths[0], times, 0.2), photograph(paths[1], times, 0.8);
    photograph(paths[2], times, 0.5);
}

static void finer_photographs_give_shares(void **state) {
    (void)state;
    take_photographs(TIMES);
    assert_true(refined(TIMES, 0));
}

static void photographs_hardly_wider_give_none(void **state) {
    (void)state;
    take_photographs(1);
    assert_false(refined(1, 0));
}

// They existed when they were first read.
static void photographs_that_cannot_be_read_again_leave_the_mask(void **state) {
    (void)state;
    take_photographs(TIMES);
    assert_true(ffp_write_file(paths[2], "GIF89a", 6, NULL));
    assert_false(refined(TIMES, 0));
    photograph(paths[2], 2 * TIMES, 0.5);
    assert_false(refined(TIMES, 0));
    assert_int_equal(remove(paths[2]), 0);
    assert_false(refined(TIMES, 0));
}

static void a_mask_of_something_else_stays(void **state) {
    (void)state;
    take_photographs(TIMES);
    assert_true(refined(TIMES, 1));
    assert_false(refined(TIMES, 7));
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(finer_photographs_give_shares),
                                       cmocka_unit_test(photographs_hardly_wider_give_none),
                                       cmocka_unit_test(photographs_that_cannot_be_read_again_leave_the_mask),
                                       cmocka_unit_test(a_mask_of_something_else_stays)};
    return cmocka_run_group_tests(tests, setup, scratch_teardown);
}
