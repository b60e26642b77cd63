// Captures with fewer pixels: what cameras with larger pixels would have taken.
#include <tgmath.h>
#include "core/base/rng.h"
#include "core/capture/reduce.h"
#include "support.h"

enum { WIDE = 24, HIGH = 16, PATTERNS = 4 };

typedef struct World {
    FfpCapture capture;
    FfpView view;
    FfpImage images[PATTERNS];
    FfpPattern patterns[PATTERNS];
} World;

// One view of a half-covered picture: columns from 9 on are the object's, column 9 by a quarter.
static void world_new(World *w, real light) {
    *w = (World){.view = {.id = "only", .camera = {WIDE, HIGH, 20, 22, 11, 7, {0}}}};
    w->capture =
        (FfpCapture){.n_patterns = PATTERNS, .n_views = 1, .patterns = w->patterns, .views = &w->view};
    w->view.images = w->images;
    w->view.coverage = ffp_image_new(WIDE, HIGH, 1);
    for (int p = 0; p < PATTERNS - 1; p++) w->images[p] = ffp_image_new(WIDE, HIGH, 3);
    for (int i = 0; i < WIDE * HIGH; i++) {
        const real share = i % WIDE < 9 ? 0 : i % WIDE == 9 ? 0.25F : 1;
        const real premultiplied[3] = {share * light, share * light / 2, 0};
        w->view.coverage.data[i] = share;
        for (int p = 0; p < PATTERNS - 1; p++)
            ffp_shown_radiance(w->images[p].data + (size_t)3 * i, premultiplied, share);
    }
}

static void world_free(World *w) {
    ffp_image_free(&w->view.coverage);
    for (int p = 0; p < PATTERNS; p++) ffp_image_free(&w->images[p]);
}

static void test_own_colour_stays(void **state) {
    (void)state;
    const int kept[2] = {0, 2};
    World w;
    world_new(&w, 0.4F);
    FfpCapture small = ffp_capture_reduced(&w.capture, 1, kept, 2, WIDE / 4, HIGH / 4);
    const FfpView *view = &small.views[0];
    assert_string_equal(view->id, "only");
    assert_int_equal(view->camera.width, WIDE / 4);
    assert_float_equal(view->camera.fx, 5, 1e-6F);
    assert_float_equal(view->camera.cy, 1.75F, 1e-6F);
    assert_null(view->images[1].data);
    assert_null(view->images[3].data);
    for (int i = 0; i < WIDE * HIGH / 16; i++) {
        const int column = i % (WIDE / 4);
        const real share = column < 2 ? 0 : column == 2 ? 2.25F / 4 : 1;
        assert_float_equal(view->coverage.data[i], share, 1e-5F);
        if (share == 0) continue;
        real own[3]; // half-covered or not, the object's own colour is the same
        ffp_own_radiance(own, view->images[2].data + (size_t)3 * i, share);
        assert_float_equal(own[0], 0.4F, 1e-4F);
        assert_float_equal(own[1], 0.2F, 1e-4F);
        assert_float_equal(own[2], 0, 1e-4F);
    }
    ffp_capture_reduced_free(&small);
    world_free(&w);
}

// All views by one factor, with all their photographs.
static void test_narrowed(void **state) {
    (void)state;
    World w;
    world_new(&w, 0.4F);
    FfpView both[2] = {w.view, w.view};
    both[1].camera.width /= 2, both[1].camera.height /= 2; // as of a camera with fewer pixels
    both[1].coverage = ffp_image_resize(&w.view.coverage, WIDE / 2, HIGH / 2);
    FfpImage images[PATTERNS] = {0};
    for (int p = 0; p < PATTERNS - 1; p++) images[p] = ffp_image_resize(&w.images[p], WIDE / 2, HIGH / 2);
    both[1].images = images;
    FfpCapture two = w.capture;
    two.n_views = 2, two.views = both;
    FfpCapture small = ffp_capture_narrowed(&two, 18);
    assert_int_equal(small.views[0].camera.width, 18);
    assert_int_equal(small.views[0].camera.height, 12);
    assert_int_equal(small.views[1].camera.width, 9);
    assert_float_equal(small.views[0].camera.fx, 15, 1e-5F);
    for (int p = 0; p < PATTERNS; p++)
        assert_int_equal(small.views[1].images[p].data != NULL, p < PATTERNS - 1);
    ffp_capture_reduced_free(&small);
    for (int p = 0; p < PATTERNS; p++) ffp_image_free(&images[p]);
    ffp_image_free(&both[1].coverage);
    world_free(&w);
}

// Encoding and its reverse, for random radiance and coverage.
static void test_shown_and_own(void **state) {
    (void)state;
    FfpRng rng = ffp_rng(3, 1);
    for (int i = 0; i < 1000; i++) {
        const real share = ffp_rng_range(&rng, 0.06F, 1);
        const real own[3] = {ffp_rng_uniform(&rng), ffp_rng_uniform(&rng), ffp_rng_uniform(&rng)};
        const real light[3] = {share * own[0], share * own[1], share * own[2]};
        real shown[3], back[3];
        ffp_shown_radiance(shown, light, share);
        ffp_own_radiance(back, shown, share);
        for (int c = 0; c < 3; c++) assert_float_equal(back[c], own[c], 2e-4F);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_own_colour_stays),
        cmocka_unit_test(test_narrowed),
        cmocka_unit_test(test_shown_and_own),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
