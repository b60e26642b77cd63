// Where a highlight is, on a plane whose specular radiance is known by hand.
#include <math.h>
#include "lab/eval/subject.h"
#include "support.h"

#define SIDE 9
#define DISTANCE 2.0F

// Camera and projector at the same place, two units in front of a plane that faces them: at the middle pixel
// n = l = v = h, so the specular part is I / d^2 a^2 / (pi a^4) F (1/4 of 1) with F = 0.04 + 0.96 * 2^-12.54.
static FfpView facing(real roughness) {
    FfpView view = {.camera = {SIDE, SIDE, SIDE, SIDE, SIDE / 2.0F, SIDE / 2.0F, {0}}};
    for (int i = 0; i < 4; i++) view.camera.pose[5 * i] = 1;
    view.projector = view.camera;
    view.depth = ffp_image_new(SIDE, SIDE, 1);
    view.normal = ffp_image_new(SIDE, SIDE, 3);
    view.roughness = ffp_image_new(SIDE, SIDE, 1);
    view.direct_white = ffp_image_new(SIDE, SIDE, 3);
    for (int p = 0; p < SIDE * SIDE; p++) {
        view.depth.data[p] = DISTANCE;
        view.normal.data[3 * p + 2] = -1;
        view.roughness.data[p] = roughness;
        for (int k = 0; k < 3; k++) view.direct_white.data[3 * p + k] = 1;
    }
    return view;
}

static void free_view(FfpView *view) {
    ffp_image_free(&view->depth);
    ffp_image_free(&view->normal);
    ffp_image_free(&view->roughness);
    ffp_image_free(&view->direct_white);
}

static int marked(const FfpView *view, real brightness) {
    FfpImage mask = ffp_gloss_mask(view, (const real[3]){brightness, brightness, brightness});
    int count = 0;
    for (int p = 0; p < SIDE * SIDE; p++) {
        assert_true(mask.data[p] == 0 || mask.data[p] == 1);
        count += mask.data[p] == 1;
    }
    if (count) assert_true(mask.data[SIDE * SIDE / 2] == 1); // the mirror direction, if any
    ffp_image_free(&mask);
    return count;
}

// The intensity at which the middle pixel's specular part is 0.05.
static double threshold(double roughness) {
    const double a = roughness * roughness, fresnel = 0.04 + 0.96 * exp2(-5.55473 - 6.98316);
    return 0.05 * DISTANCE * DISTANCE * 4 * 3.14159265 * a * a / fresnel;
}

static void test_the_middle_shines_from_its_threshold_on(void **state) {
    (void)state;
    for (int i = 3; i < 9; i++) {
        const real roughness = 0.1F * (real)i;
        FfpView view = facing(roughness);
        assert_int_equal(marked(&view, (real)(0.99 * threshold(roughness))), 0);
        const int at = marked(&view, (real)(1.01 * threshold(roughness)));
        assert_int_equal(at, 1);
        assert_true(marked(&view, (real)(10 * threshold(roughness))) > at);
        free_view(&view);
    }
}

static void test_shadows_and_missing_truth_do_not_shine(void **state) {
    (void)state;
    FfpView view = facing(0.5F);
    const real bright = (real)(2 * threshold(0.5));
    const int all = marked(&view, bright);
    const int beside = SIDE * SIDE / 2 + 1;
    for (int k = 0; k < 3; k++) view.direct_white.data[3 * beside + k] = 0; // in shadow
    assert_int_equal(marked(&view, bright), all - 1);
    view.depth.data[SIDE * SIDE / 2 - 1] = 0; // no surface
    assert_int_equal(marked(&view, bright), all - 2);
    ffp_image_free(&view.roughness);
    view.roughness = (FfpImage){0};
    assert_int_equal(marked(&view, bright), 0);
    free_view(&view);
}

static void test_what_faces_away_does_not_shine(void **state) {
    (void)state;
    FfpView view = facing(0.5F);
    for (int p = 0; p < SIDE * SIDE; p++) view.normal.data[3 * p + 2] = 1;
    assert_int_equal(marked(&view, (real)(9 * threshold(0.5))), 0);
    free_view(&view);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_the_middle_shines_from_its_threshold_on),
        cmocka_unit_test(test_shadows_and_missing_truth_do_not_shine),
        cmocka_unit_test(test_what_faces_away_does_not_shine),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
