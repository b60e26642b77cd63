// The margins of a whole scene's views: a wall goes on beyond the frames, once, and nowhere that a view sees.
#include <math.h>
#include "core/base/alloc.h"
#include "engine/pipeline/margins.h"
#include "support.h"

enum { WIDTH = 40, HEIGHT = 30, AREA = WIDTH * HEIGHT };

// Cameras side by side that look along z at the wall z = 2; f = WIDTH, so the wall is seen 2 wide.
static FfpCapture wall_capture(int views, real apart) {
    FfpCapture capture = {.n_views = views, .scene = true, .radius = 1};
    capture.views = ffp_alloc((size_t)views, sizeof *capture.views);
    for (int v = 0; v < views; v++)
        capture.views[v].camera = (FfpCamera){WIDTH,
                                              HEIGHT,
                                              WIDTH,
                                              WIDTH,
                                              WIDTH / 2.0F,
                                              HEIGHT / 2.0F,
                                              {1, 0, 0, apart * (real)v, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}};
    return capture;
}

static FfpInitialisation wall_start(const FfpCapture *capture) {
    const size_t n = (size_t)capture->n_views * AREA;
    FfpInitialisation start = {.views = capture->n_views, .width = WIDTH, .height = HEIGHT};
    start.t = ffp_alloc(n, sizeof(real)), start.footprint = ffp_alloc(n, sizeof(real));
    start.coverage = ffp_alloc(n, sizeof(real)), start.normal = ffp_alloc(n, 3 * sizeof(real));
    start.albedo = ffp_alloc(n, 3 * sizeof(real)), start.ambient = ffp_alloc(n, 3 * sizeof(real));
    for (size_t i = 0; i < n; i++) {
        const FfpCamera *camera = &capture->views[i / AREA].camera;
        real direction[3];
        const real along =
            ffp_pixel_ray(camera, (real)(i % WIDTH) + 0.5F, (real)(i % AREA / WIDTH) + 0.5F, direction);
        start.t[i] = 2 / along, start.footprint[i] = 2 / camera->fx, start.coverage[i] = 1;
        start.normal[3 * i + 2] = -1;
        for (int c = 0; c < 3; c++) start.albedo[3 * i + (size_t)c] = start.ambient[3 * i + (size_t)c] = 0.3F;
    }
    return start;
}

static int64_t margins_of(int views, real apart, FfpGaussians *out) {
    FfpCapture capture = wall_capture(views, apart);
    FfpInitialisation start = wall_start(&capture);
    *out = ffp_gaussians_new(1);
    out->albedo[0] = 0.75F;
    const int64_t count = ffp_margins_add(out, &capture, &start);
    assert_int_equal(out->count, count + 1);
    assert_float_equal(out->albedo[0], 0.75F, 0); // what was there stays first
    for (int64_t i = 1; i <= count; i++) {
        const real *at = out->centre + 3 * i;
        assert_float_equal(at[2], 2, 1e-4);
        assert_float_equal(out->ambient[3 * i], 0.3F, 1e-3);
        for (int v = 0; v < views; v++) { // off every frame
            real x, y;
            ffp_project(&capture.views[v].camera, at, &x, &y);
            assert_true(x < 0 || y < 0 || x > WIDTH || y > HEIGHT);
        }
    }
    ffp_initialisation_free(&start);
    ffp_free(capture.views);
    return count;
}

static void a_wall_goes_on_around_one_frame(void **state) {
    (void)state;
    FfpGaussians gaussians;
    assert_int_equal(margins_of(1, 0, &gaussians), 48 * 38 - AREA);
    ffp_gaussians_free(&gaussians);
}

// The second view's frame and margin begin half a frame further: of the wall between, nothing is added, and
// above and below it once.
static void margins_of_several_views_do_not_repeat_each_other(void **state) {
    (void)state;
    FfpGaussians gaussians;
    const int64_t count = margins_of(2, 1, &gaussians);
    assert_in_range(count, (48 + 20) * 38 - 60 * HEIGHT - 30, (48 + 20) * 38 - 60 * HEIGHT + 30);
    ffp_gaussians_free(&gaussians);
}

static void a_wall_from_behind_does_not_go_on(void **state) {
    (void)state;
    FfpCapture capture = wall_capture(1, 0);
    FfpInitialisation start = wall_start(&capture);
    FfpGaussians gaussians = ffp_gaussians_new(1);
    for (size_t i = 0; i < AREA; i++) start.normal[3 * i + 2] = 1;
    assert_int_equal(ffp_margins_add(&gaussians, &capture, &start), 0);
    ffp_gaussians_free(&gaussians);
    ffp_initialisation_free(&start);
    ffp_free(capture.views);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_wall_goes_on_around_one_frame),
        cmocka_unit_test(margins_of_several_views_do_not_repeat_each_other),
        cmocka_unit_test(a_wall_from_behind_does_not_go_on),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
