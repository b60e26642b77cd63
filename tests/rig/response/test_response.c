// The projector's response found from photographs: pictures are made again from a rendered capture's black
// and white ones, its true depth and a projector of known gamma and black level.
#include <math.h>
#include "core/image/lookup.h"
#include "rig/response/response.h"
#include "support.h"

static FfpCapture capture;
static int all_views;
static FfpResponse found;
static FfpError err;
static const double gamma_true[3] = {2.2, 1.8, 2.6};

static int setup(void **state) {
    (void)state;
    if (!ffp_capture_read(&capture, FFP_SOURCE_DIR "/data/sample", NULL)) return 1;
    all_views = capture.n_views, capture.n_views = 3; // which is quicker
    return 0;
}

static int teardown(void **state) {
    (void)state;
    capture.n_views = all_views;
    ffp_capture_free(&capture);
    return 0;
}

static int active(void) {
    return ffp_capture_active_pattern(&capture, NULL, NULL);
}

static void shoot_pixel(const FfpView *view, const FfpSummed *sent, size_t i, double black, bool dark) {
    real ray[3], point[3], u, v, light[3];
    const size_t w = (size_t)view->camera.width;
    const real z = view->depth.data[i],
               toward = ffp_pixel_ray(&view->camera, (real)(i % w) + 0.5F, (real)(i / w) + 0.5F, ray);
    for (int c = 0; c < 3; c++) point[c] = view->camera.pose[4 * c + 3] + ray[c] * z / toward;
    ffp_project(&view->projector, point, &u, &v);
    ffp_lookup(sent, u, v, 7, 7, light);
    for (int c = 0; c < 3; c++) {
        real *b = &view->images[capture.black].data[3 * i + (size_t)c],
             *w_ = &view->images[capture.white].data[3 * i + (size_t)c];
        const double lamp = (double)(*w_ - *b), room = dark ? 0 : (double)*b;
        *b = (real)(room + black * lamp), *w_ = (real)(room + lamp);
        if (z > 0)
            view->images[active()].data[3 * i + (size_t)c] =
                (real)(room + lamp * (black + (1 - black) * (double)light[c]));
    }
}

// Pictures that a projector of that gamma and black level gives, in a dark room or in the sample's light.
static void shoot(double black, bool dark) {
    FfpImage image = ffp_image_copy(&capture.patterns[active()].image);
    for (int i = 0; i < 3 * image.width * image.height; i++)
        image.data[i] = (real)pow((double)ffp_srgb_encode(image.data[i]), gamma_true[i % 3]);
    FfpSummed sent = ffp_summed_new(&image);
    for (int v = 0; v < capture.n_views; v++)
        for (size_t i = 0; i < 128 * 128; i++) shoot_pixel(&capture.views[v], &sent, i, black, dark);
    ffp_summed_free(&sent);
    ffp_image_free(&image);
}

static bool fit(void) {
    err.text[0] = 0;
    const bool ok = ffp_fit_response(&found, &capture, active(), false, &err);
    printf("%s: gamma %.3f %.3f %.3f (%.3f), black %.4f %.4f %.4f %d, intensity %.2f\n", ok ? "ok" : err.text,
           found.gamma[0], found.gamma[1], found.gamma[2], found.gamma_deviation[0], found.black[0],
           found.black[1], found.black[2], found.black_known, found.intensity);
    return ok;
}

static void check_gamma(void) {
    for (int c = 0; c < 3; c++) assert_true(fabs(found.gamma[c] / gamma_true[c] - 1) < 0.02);
}

// Within 2 %, each channel its own; the black level is that of the projector.
static void test_dark_room(void **state) {
    (void)state;
    shoot(0.05, true);
    assert_true(fit());
    check_gamma();
    assert_true(found.black_known);
    for (int c = 0; c < 3; c++) assert_true(fabs(found.black[c] - 0.05) < 0.02 * 0.05);
}

// The room's light hides the black level: only a bound is told, which holds.
static void test_lit_room(void **state) {
    (void)state;
    shoot(0.02, false);
    assert_true(fit());
    check_gamma();
    assert_false(found.black_known);
    for (int c = 0; c < 3; c++) assert_true(found.black[c] >= 0.02);
}

// As rendered: sRGB's curve, which no power is, but 2.2 nearly; and the intensity that the renderer had.
static void test_as_rendered(void **state) {
    (void)state;
    SAME_WAY_AGAIN(); // test_lit_room
    assert_true(fit());
    for (int c = 0; c < 3; c++) assert_true(found.gamma[c] > 2.0 && found.gamma[c] < 2.4);
    assert_true(found.intensity > 0.4 * (double)capture.intensity[0] &&
                found.intensity < 2.5 * (double)capture.intensity[0]);
}

static void test_apply(void **state) {
    (void)state;
    FfpImage image = ffp_image_new(2, 1, 3);
    const FfpResponse response = {.gamma = {2, 1, 3}};
    for (int i = 0; i < 6; i++) image.data[i] = ffp_srgb_decode(0.5F);
    ffp_response_apply(&response, false, &image);
    const double powers[3] = {0.25, 0.5, 0.125};
    for (int i = 0; i < 6; i++) assert_true(fabs((double)image.data[i] - powers[i % 3]) < 1e-5);
    for (int i = 0; i < 6; i++) image.data[i] = 0.5F;
    ffp_response_apply(&response, true, &image);
    for (int i = 0; i < 6; i++) assert_true(fabs((double)image.data[i] - powers[i % 3]) < 1e-5);
    ffp_image_free(&image);
}

// Greys of a known gamma, a little off, and of an sRGB projector, which no gamma describes as well.
static void test_greys(void **state) {
    (void)state;
    FfpGrey greys[6];
    FfpResponse response;
    double errors[2];
    for (int i = 0; i < 6; i++) {
        greys[i].value = (i + 1) / 7.0;
        for (int c = 0; c < 3; c++)
            greys[i].light[c] = pow(greys[i].value, gamma_true[c]) + (i % 2 ? 0.001 : -0.001);
    }
    ffp_fit_greys(&response, greys, 6, false, errors);
    for (int c = 0; c < 3; c++) {
        assert_float_equal(response.gamma[c], gamma_true[c], 0.02);
        assert_true(response.gamma_deviation[c] > 5e-4 && response.gamma_deviation[c] < 0.01);
    }
    assert_true(errors[1] < 0.004 && errors[0] > 0.02);
    for (int i = 0; i < 6; i++)
        for (int c = 0; c < 3; c++) greys[i].light[c] = (double)ffp_srgb_decode((real)greys[i].value);
    ffp_fit_greys(&response, greys, 6, false, errors);
    assert_true(errors[0] < 1e-6 && errors[1] > 1e-3);
    for (int i = 0; i < 6; i++)
        for (int c = 0; c < 3; c++) greys[i].light[c] = greys[i].value;
    ffp_fit_greys(&response, greys, 6, true, errors);
    assert_true(errors[0] < 1e-6);
    assert_float_equal(response.gamma[1], 1, 1e-4);
}

// Colours at their limits only: nothing is said about what lies between.
static void test_saturated_pattern(void **state) {
    (void)state;
    FfpImage *image = &capture.patterns[active()].image;
    for (int i = 0; i < 3 * image->width * image->height; i++) image->data[i] = image->data[i] > 0.2F;
    shoot(0, true);
    assert_false(fit());
    assert_non_null(strstr(err.text, "mid-range values"));
    assert_non_null(strstr(err.text, "fit_response"));
}

static void test_unlit(void **state) {
    (void)state;
    for (int v = 0; v < capture.n_views; v++)
        for (int i = 0; i < 3 * 128 * 128; i++) {
            const real black = capture.views[v].images[capture.black].data[i];
            real *white = &capture.views[v].images[capture.white].data[i];
            *white = black + 0.03F * (*white - black);
        }
    assert_false(fit());
    assert_non_null(strstr(err.text, "pixels are lit"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_dark_room, setup, teardown),
        cmocka_unit_test_setup_teardown(test_lit_room, setup, teardown),
        cmocka_unit_test_setup_teardown(test_as_rendered, setup, teardown),
        cmocka_unit_test(test_apply),
        cmocka_unit_test(test_greys),
        cmocka_unit_test_setup_teardown(test_saturated_pattern, setup, teardown),
        cmocka_unit_test_setup_teardown(test_unlit, setup, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
