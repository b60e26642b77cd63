// The splats' inputs from a look: nothing where the pictures are right, and the error where and as it is.
#include "core/image/srgb_formula.h"
#include "engine/network/look.h"
#include "scene.h"

enum { VIEWS = 3, SIDE = 24, AREA = SIDE * SIDE, WIDTH = FFP_LOOK_SEEN + FFP_PLAIN_NUMBERS };
// Where its parts begin (look_formula.h).
enum {
    MEAN_3 = FFP_LOOK_ERRORS,
    MEAN_7 = 2 * FFP_LOOK_ERRORS,
    BEHIND = 3 * FFP_LOOK_ERRORS + FFP_LOOK_NEIGHBOURS,
    ELSEWHERE = BEHIND + 2 + FFP_LOOK_SLOPES,
    SHARE = ELSEWHERE + FFP_LOOK_ERRORS,
    RAW = FFP_LOOK_SEEN
};

typedef struct Look {
    Scene scene;
    FfpGaussians ball; // half the radius of the scene's sphere
    FfpViewPass *pass;
    real maps[VIEWS * AREA * FFP_LOOK_NUMBERS];
} Look;

static FfpGaussians ball_new(void) {
    enum { RINGS = 24, ROUND = 48 };
    FfpGaussians g = ffp_gaussians_new(RINGS * ROUND);
    for (int i = 0; i < g.count; i++) {
        const double up = FFP_PI_DOUBLE * (i / ROUND + 0.5) / RINGS,
                     round = 2 * FFP_PI_DOUBLE * (i % ROUND) / ROUND;
        const real place[3] = {(real)(0.5 * sin(up) * cos(round)), (real)(0.5 * sin(up) * sin(round)),
                               (real)(0.5 * cos(up))};
        for (int k = 0; k < 3; k++) {
            g.centre[3 * i + k] = place[k];
            g.scale[3 * i + k] = 0.05F;
            g.albedo[3 * i + k] = 0.4F;
            g.ambient[3 * i + k] = 0.05F;
        }
        g.rotation[4 * i] = g.opacity[i] = 1;
        g.roughness[i] = 0.5F;
    }
    return g;
}

// Photographs become what is drawn.
static void photograph(Look *l) {
    FfpCapture *c = &l->scene.capture;
    for (int v = 0; v < VIEWS; v++) {
        FfpView *view = &c->views[v];
        ffp_view_pass_draw(l->pass, &l->ball, &view->camera, &view->projector);
        for (int p = 0; p < 3; p++) {
            FfpSummed light = ffp_summed_new(&c->patterns[p].image);
            ffp_view_pass_shade(l->pass, c->intensity, p ? &light : NULL, &view->images[p]);
            for (int i = 0; i < 3 * AREA; i++)
                view->images[p].data[i] = ffp_srgb_decode(view->images[p].data[i]);
            ffp_summed_free(&light);
        }
        memcpy(view->coverage.data, ffp_view_pass_gbuffer(l->pass)->opacity, AREA * sizeof(real));
    }
}

static int set_up(void **state) {
    Look *l = ffp_alloc(1, sizeof *l);
    scene_new(&l->scene, VIEWS, SIDE, SIDE, 1);
    for (int v = 0; v < VIEWS; v++)
        l->scene.capture.views[v].camera = l->scene.capture.views[v].projector =
            circle_camera(SIDE, SIDE, 0.3 * v);
    l->ball = ball_new();
    const FfpRenderSettings render = ffp_render_settings(false, 2);
    l->pass = ffp_view_pass_new(&render);
    photograph(l);
    *state = l;
    return 0;
}

static int tear_down(void **state) {
    Look *l = *state;
    ffp_view_pass_free(l->pass);
    ffp_gaussians_free(&l->ball);
    scene_free(&l->scene);
    ffp_free(l);
    return 0;
}

// Of a splat at the ball's point nearest to the first camera, from that camera's middle pixel.
static void look(Look *l, real depth, real out[WIDTH]) {
    FfpLookPhotographs *p = ffp_look_photographs_new(&l->scene.capture, VIEWS, SCENE_ACTIVE);
    ffp_look(l->maps, l->pass, &l->ball, p);
    const int64_t pixel = SIDE / 2 * SIDE + SIDE / 2;
    const real centre[3] = {3 - depth, 0, 0}, raw[FFP_PLAIN_NUMBERS] = {7, 8};
    const FfpLookInputs inputs = {ffp_look_maps(p, l->maps), &pixel, centre, raw, FFP_PLAIN_NUMBERS};
    ffp_look_gather(out, &inputs, 0, 1);
    ffp_look_photographs_free(p);
}

static void test_right_pictures_show_no_error(void **state) {
    real seen[WIDTH];
    look(*state, 2.5F, seen);
    for (int k = 0; k < BEHIND; k++) assert_float_equal(seen[k], 0, 2e-3);
    for (int k = ELSEWHERE; k < SHARE; k++) assert_float_equal(seen[k], 0, 2e-3);
    assert_float_equal(seen[BEHIND], 0, 0.1);
    assert_float_equal(seen[BEHIND + 1], 1, 0);
    assert_float_equal(seen[SHARE], 2.0 / 3, 1e-6); // the two others see it
    assert_float_equal(seen[RAW], 7, 0);
    assert_float_equal(seen[RAW + 1], 8, 0);
}

static void brighten(FfpView *view, int pattern, int pixel, real by) {
    for (int i = 0; i < AREA; i++)
        for (int k = 0; k < 3 && (pixel < 0 || i == pixel); k++) {
            real *value = &view->images[pattern].data[3 * i + k];
            *value = ffp_srgb_decode(ffp_srgb_encode(*value) + by);
        }
}

static void test_an_error_shows_where_it_is(void **state) {
    Look *l = *state;
    real seen[WIDTH];
    brighten(&l->scene.capture.views[0], 1, SIDE / 2 * SIDE + SIDE / 2, 0.1F);
    brighten(&l->scene.capture.views[2], SCENE_ACTIVE, -1, 0.2F);
    look(l, 2.5F, seen);
    const real own = FFP_LOOK_GAIN * 0.1F, theirs = FFP_LOOK_GAIN * 0.2F;
    assert_float_equal(seen[0], 0, 2e-3);   // black
    assert_float_equal(seen[3], own, 2e-3); // white
    assert_float_equal(seen[MEAN_3 + 3], own / 9, 2e-3);
    assert_float_equal(seen[MEAN_7 + 3], own / 49, 2e-3);
    assert_float_equal(seen[6], 0, 2e-3);
    assert_float_equal(seen[ELSEWHERE + 3], 0, 2e-3);
    assert_float_equal(seen[ELSEWHERE + 6], theirs / 2, 2e-3); // in one of the two
}

static void test_a_splat_behind_the_surface(void **state) {
    real seen[WIDTH];
    const real footprint = 2.5F / (1.4F * SIDE);
    look(*state, 2.5F + 2 * footprint, seen);
    assert_float_equal(seen[BEHIND], 2 / FFP_LOOK_REACH, 0.1);
    look(*state, 2.5F + 8 * footprint, seen); // too far behind: the others do not see it
    assert_float_equal(seen[BEHIND], 1, 1e-6);
    assert_float_equal(seen[SHARE], 0, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_right_pictures_show_no_error, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_an_error_shows_where_it_is, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_a_splat_behind_the_surface, set_up, tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
