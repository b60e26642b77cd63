// Fits from coarse to fine: smaller pictures, fewer splats, and what they learn carried back.
// Labels: threads
#include <omp.h>
#include <tgmath.h>
#include "core/base/alloc.h"
#include "core/base/rng.h"
#include "core/base/vec.h"
#include "core/capture/reduce.h"
#include "engine/refine/pyramid.h"
#include "engine/refine/reduce.h"
#include "engine/render/pass.h"
#include "looking.h"
#include "stopped.h"
#include "support.h"

#define VIEWS 4
#define BALL 0.6F

enum { BLACK, WHITE, STRIPES, PATTERNS };
static const int all_patterns[] = {BLACK, WHITE, STRIPES};

static FfpCamera look_at_origin(real azimuth, real height, real distance, int width, int height_px,
                                real focal) {
    const real eye[3] = {distance * cos(azimuth), distance * sin(azimuth), height};
    return looking_at_origin(eye, width, height_px, focal);
}

// Where the ray through a pixel first meets the ball.
static bool meets_ball(const FfpCamera *camera, int x, int y, real point[3], real *distance) {
    const real o[3] = {camera->pose[3], camera->pose[7], camera->pose[11]};
    real d[3];
    ffp_pixel_ray(camera, (real)x + 0.5F, (real)y + 0.5F, d);
    const real b = ffp_dot3(o, d), rest = b * b - ffp_dot3(o, o) + BALL * BALL;
    if (rest < 0) return false;
    *distance = -b - sqrt(rest);
    for (int k = 0; k < 3; k++) point[k] = o[k] + *distance * d[k];
    return true;
}

static void lay_splat(FfpGaussians *g, int64_t i, const real point[3], real footprint) {
    const real n[3] = {point[0] / BALL, point[1] / BALL, point[2] / BALL}, length = sqrt(2 + 2 * n[2]);
    const real q[4] = {1 + n[2], -n[1], n[0], 0};
    for (int k = 0; k < 3; k++) {
        g->centre[3 * i + k] = point[k];
        g->scale[3 * i + k] = footprint * (k < 2 ? 0.45F : 0.05F);
        g->albedo[3 * i + k] = 0.5F + 0.3F * sin(9 * n[k] + (real)k);
        g->ambient[3 * i + k] = 0.1F + 0.05F * n[k];
    }
    for (int k = 0; k < 4; k++) g->rotation[4 * i + k] = length > 0 ? q[k] / length : k == 1;
    g->opacity[i] = 0.92F;
    g->roughness[i] = 0.6F;
}

// A splat for each pixel of each view that sees the ball; their pixels are the caller's to free.
static FfpGaussians ball_of_pixels(const FfpCapture *c, int64_t **pixel) {
    const int width = c->views[0].camera.width, height = c->views[0].camera.height;
    FfpGaussians g = ffp_gaussians_new((int64_t)VIEWS * width * height);
    int64_t count = 0;
    *pixel = ffp_alloc((size_t)g.count, sizeof **pixel);
    for (int64_t p = 0; p < g.count; p++) {
        const FfpCamera *camera = &c->views[p / width / height].camera;
        real point[3], distance;
        if (!meets_ball(camera, (int)(p % width), (int)(p / width % height), point, &distance)) continue;
        (*pixel)[count] = p;
        lay_splat(&g, count++, point, distance / camera->fx);
    }
    g.count = count;
    return g;
}

static FfpImage pattern_image(int pattern) {
    FfpImage image = ffp_image_new(32, 32, 3);
    for (int i = 0; i < 32 * 32 * 3; i++)
        image.data[i] = pattern == WHITE ? 1 : pattern == STRIPES ? (real)(i / 3 / 4 % 2) : 0;
    return image;
}

static void photograph(FfpView *view, const FfpGaussians *truth, const FfpCapture *capture) {
    const FfpRenderSettings settings = ffp_render_defaults();
    FfpViewPass *pass = ffp_view_pass_new(&settings);
    ffp_view_pass_draw(pass, truth, &view->camera, &view->projector);
    const FfpGbuffer *g = ffp_view_pass_gbuffer(pass);
    view->images = ffp_alloc(PATTERNS, sizeof *view->images);
    view->coverage = ffp_image_new(g->width, g->height, 1);
    for (int i = 0; i < g->width * g->height; i++)
        view->coverage.data[i] = g->opacity[i] > 0.01F ? fmin(g->opacity[i], 1) : 0;
    for (int p = 0; p < PATTERNS; p++) {
        FfpSummed light = ffp_summed_new(&capture->patterns[p].image);
        view->images[p] = ffp_view_pass_picture_new(pass);
        ffp_view_pass_shade(pass, capture->intensity, p == BLACK ? NULL : &light, &view->images[p]);
        ffp_image_to_linear(&view->images[p]);
        ffp_summed_free(&light);
    }
    ffp_view_pass_free(pass);
}

// A ball that fills most of the pictures' height; a fifth view that fits never see.
typedef struct Scene {
    FfpCapture capture;
    FfpGaussians truth;
    FfpOrigin origin;
    int64_t *pixel;
} Scene;

static Scene scene_new(int width, int height) {
    Scene s = {.capture = {.n_patterns = PATTERNS,
                           .n_views = VIEWS,
                           .patterns = ffp_alloc(PATTERNS, sizeof *s.capture.patterns),
                           .views = ffp_alloc(VIEWS + 1, sizeof *s.capture.views),
                           .black = BLACK,
                           .white = WHITE,
                           .intensity = {4, 4, 4},
                           .radius = 1}};
    FfpCapture *c = &s.capture;
    for (int p = 0; p < PATTERNS; p++) c->patterns[p].image = pattern_image(p);
    for (int v = 0; v <= VIEWS; v++) {
        const real azimuth = (real)(v < VIEWS ? v : 0.5) * 6.2831853F / VIEWS;
        c->views[v].camera = look_at_origin(azimuth, 0.3F, 2.5F, width, height, (real)height);
        c->views[v].projector = look_at_origin(azimuth + 0.2F, 1, 2, 32, 32, 40);
    }
    s.truth = ball_of_pixels(c, &s.pixel);
    s.origin = (FfpOrigin){VIEWS, width, height, s.pixel};
    for (int v = 0; v <= VIEWS; v++) photograph(&c->views[v], &s.truth, c);
    return s;
}

static void scene_free(Scene *s) {
    s->capture.n_views = VIEWS + 1;
    ffp_capture_free(&s->capture);
    ffp_gaussians_free(&s->truth);
    ffp_free(s->pixel);
}

// Colours wrong over wide areas, and each splat a little out of place.
static FfpGaussians disturbed(const FfpGaussians *truth) {
    FfpGaussians g = ffp_gaussians_copy(truth);
    FfpRng rng = ffp_rng(5, 1);
    for (int64_t i = 0; i < 3 * g.count; i++) {
        g.albedo[i] *= 0.5F + 0.2F * sin(6 * g.centre[i]);
        g.ambient[i] *= 2;
        g.centre[i] += 5e-4F * ffp_rng_normal(&rng);
    }
    return g;
}

static double psnr_of_view(const Scene *s, const FfpGaussians *g, int view) {
    FfpCapture one = s->capture;
    const FfpRenderSettings render = ffp_render_defaults();
    one.views += view;
    one.n_views = 1;
    return ffp_photographs_psnr(g, &one, all_patterns, PATTERNS, &render);
}

static FfpRefineSettings settings_of(int64_t steps) {
    FfpRefineSettings s = ffp_polish_defaults(steps);
    s.quiet = true;
    return s;
}

static bool same_bits(const FfpGaussians *a, const FfpGaussians *b) {
    bool same = a->count == b->count;
    for (int t = 0; same && t < FFP_ATTRIBUTES; t++) {
        const FfpAttribute x = ffp_attribute(a, t), y = ffp_attribute(b, t);
        same = memcmp(x.data, y.data, (size_t)(a->count * x.width) * sizeof(real)) == 0;
    }
    return same;
}

static void test_small_pictures_are_fitted_as_ever(void **state) {
    (void)state;
    Scene s = scene_new(64, 48);
    FfpGaussians plain = disturbed(&s.truth), levels = ffp_gaussians_copy(&plain);
    const FfpRefineSettings settings = settings_of(12);
    FfpRefineResult a, b;
    assert_true(ffp_refine(&plain, &s.capture, all_patterns, PATTERNS, &settings, &a, NULL));
    assert_true(
        ffp_refine_pyramid(&levels, &s.origin, &s.capture, all_patterns, PATTERNS, &settings, &b, NULL));
    assert_int_equal(a.steps, b.steps);
    assert_true(same_bits(&plain, &levels));
    ffp_gaussians_free(&plain);
    ffp_gaussians_free(&levels);
    scene_free(&s);
}

// 250 x 130 halves to 125 x 65: sixteen steps there, and two rounds at full size.
static void test_levels_gain_at_seen_and_unseen_views(void **state) {
    (void)state;
    Scene s = scene_new(250, 130);
    FfpGaussians start = disturbed(&s.truth), levels = ffp_gaussians_copy(&start);
    const FfpRefineSettings settings = settings_of(16);
    FfpRefineResult result;
    assert_true(
        ffp_refine_pyramid(&levels, &s.origin, &s.capture, all_patterns, PATTERNS, &settings, &result, NULL));
    assert_int_equal(result.steps, 16 + 8);
    assert_int_equal(result.gaussians, start.count);
    assert_false(result.dropped);
    for (int view = 0; view <= VIEWS; view += VIEWS)
        assert_true(psnr_of_view(&s, &levels, view) > psnr_of_view(&s, &start, view) + 2);
    ffp_gaussians_free(&start);
    ffp_gaussians_free(&levels);
    scene_free(&s);
}

// Steps far too long destroy a fit at every size, and it is judged by drawing.
static void test_what_loses_is_dropped(void **state) {
    (void)state;
    Scene s = scene_new(250, 130);
    FfpGaussians start = disturbed(&s.truth), levels = ffp_gaussians_copy(&start);
    FfpRefineSettings settings = settings_of(16);
    FfpRefineResult result;
    for (int a = 0; a < FFP_ATTRIBUTES; a++) settings.rates.rate[a] *= 300;
    assert_true(
        ffp_refine_pyramid(&levels, &s.origin, &s.capture, all_patterns, PATTERNS, &settings, &result, NULL));
    assert_true(result.dropped);
    assert_true(same_bits(&start, &levels));
    ffp_gaussians_free(&start);
    ffp_gaussians_free(&levels);
    scene_free(&s);
}

static void test_threads_do_not_matter(void **state) {
    (void)state;
    Scene s = scene_new(250, 130);
    FfpGaussians fits[2] = {disturbed(&s.truth), disturbed(&s.truth)};
    const FfpRefineSettings settings = settings_of(4);
    const int most = omp_get_max_threads();
    FfpRefineResult result;
    for (int i = 0; i < 2; i++) {
        omp_set_num_threads(1 + 2 * i);
        assert_true(ffp_refine_pyramid(&fits[i], &s.origin, &s.capture, all_patterns, PATTERNS, &settings,
                                       &result, NULL));
    }
    omp_set_num_threads(most);
    assert_true(same_bits(&fits[0], &fits[1]));
    for (int i = 0; i < 2; i++) ffp_gaussians_free(&fits[i]);
    scene_free(&s);
}

typedef struct Fit {
    FfpGaussians *gaussians;
    const Scene *scene;
    const FfpRefineSettings *settings;
    FfpRefineResult *result;
} Fit;

static bool fit_levels(void *argument, FfpError *err) {
    const Fit *fit = argument;
    return ffp_refine_pyramid(fit->gaussians, &fit->scene->origin, &fit->scene->capture, all_patterns,
                              PATTERNS, fit->settings, fit->result, err);
}

static void test_stopping_ends_all_levels(void **state) {
    (void)state;
    Scene s = scene_new(250, 130);
    FfpGaussians g = disturbed(&s.truth);
    FfpRefineSettings settings = settings_of(100);
    FfpRefineResult result;
    settings.may_stop = true;
    assert_true(run_stopped(fit_levels, &(Fit){&g, &s, &settings, &result}, NULL));
    assert_true(result.stopped);
    assert_int_equal(result.steps, 0);
    ffp_gaussians_free(&g);
    scene_free(&s);
}

// A point keeps its place, and a picture of one colour its colour, also where the object covers a part.
static void test_reduced_pictures_show_the_same(void **state) {
    (void)state;
    const int width = 51, height = 38, side = 4;
    FfpView view = {.camera = look_at_origin(0.4F, 0.3F, 2.5F, width, height, 60),
                    .projector = look_at_origin(0.6F, 1, 2, 32, 32, 40),
                    .coverage = ffp_image_new(width, height, 1)};
    FfpImage images[1] = {ffp_image_new(width, height, 3)};
    FfpCapture c = {.n_patterns = 1, .n_views = 1, .views = &view};
    view.images = images;
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            const real a = x < 10 ? 0 : x < 30 ? 1 : 0.25F;
            view.coverage.data[y * width + x] = a;
            for (int k = 0; k < 3; k++)
                images[0].data[3 * (y * width + x) + k] = ffp_srgb_decode(a * ffp_srgb_encode(0.4F));
        }
    const int patterns[] = {0};
    FfpCapture small = ffp_reduced(&c, patterns, 1, side);
    const FfpView *v = &small.views[0];
    assert_int_equal(v->camera.width, 13);
    assert_int_equal(v->camera.height, 10);
    for (int i = 0; i < v->camera.width * v->camera.height; i++) {
        const real a = v->coverage.data[i], shown = a * ffp_srgb_encode(0.4F);
        for (int k = 0; k < 3; k++)
            assert_float_equal(ffp_srgb_encode(v->images[0].data[3 * i + k]), shown, 1e-4);
    }
    const real point[3] = {0.1F, 0.2F, -0.1F};
    real x, y, xs, ys;
    ffp_project(&view.camera, point, &x, &y);
    ffp_project(&v->camera, point, &xs, &ys);
    assert_float_equal(xs * width / 13, x, 1e-3);
    assert_float_equal(ys * height / 10, y, 1e-3);
    ffp_capture_reduced_free(&small);
    ffp_image_free(&view.coverage);
    ffp_image_free(&images[0]);
}

// The window holds the object and its margin, and the camera looks through it.
static void test_pictures_are_cut_to_the_object(void **state) {
    (void)state;
    FfpView views[2] = {0};
    FfpImage images[2][1];
    FfpCapture c = {.n_patterns = 1, .n_views = 2, .views = views};
    for (int v = 0; v < 2; v++) {
        views[v].camera = look_at_origin((real)v, 0.3F, 2.5F, 200, 100, 60);
        views[v].coverage = ffp_image_new(200, 100, 1);
        images[v][0] = ffp_image_new(200, 100, 3);
        views[v].images = images[v];
    }
    views[0].coverage.data[50 * 200 + 60] = 1; // alone
    for (int x = 150; x < 190; x++)
        views[1].coverage.data[98 * 200 + x] = 1, images[1][0].data[3 * (98 * 200 + x)] = 0.5F;
    const int patterns[] = {0};
    FfpCapture cut = ffp_reduced(&c, patterns, 1, 1);
    for (int v = 0; v < 2; v++) { // 150 - 16 to 200; 33 high for the sake of the first
        assert_int_equal(cut.views[v].camera.width, 66);
        assert_int_equal(cut.views[v].camera.height, 33);
    }
    assert_float_equal(cut.views[1].camera.cx, 100 - 134, 1e-4);
    assert_float_equal(cut.views[1].camera.cy, 50 - 67, 1e-4);
    assert_float_equal(cut.views[0].coverage.data[(50 - 34) * 66 + 60 - 44], 1, 0);
    assert_float_equal(cut.views[1].images[0].data[3 * ((98 - 67) * 66 + 16)], 0.5, 0);
    ffp_capture_reduced_free(&cut);
    for (int v = 0; v < 2; v++) ffp_image_free(&views[v].coverage), ffp_image_free(&images[v][0]);
}

// A change made to all coarse splats is made to all fine ones, and nothing else changes.
static void test_changes_are_carried(void **state) {
    (void)state;
    Scene s = scene_new(60, 50);
    FfpCoarse coarse = ffp_coarse_new(&s.truth, &s.origin, 4);
    FfpGaussians before = ffp_gaussians_copy(&coarse.gaussians), fine = ffp_gaussians_copy(&s.truth);
    assert_true(coarse.gaussians.count > s.truth.count / 16 && coarse.gaussians.count < s.truth.count / 8);
    ffp_coarse_carry(&coarse, &before, &s.origin, &fine);
    for (int64_t i = 0; i < 3 * fine.count; i++) assert_float_equal(fine.centre[i], s.truth.centre[i], 1e-6);
    for (int64_t i = 0; i < coarse.gaussians.count; i++) {
        for (int k = 0; k < 3; k++) coarse.gaussians.scale[3 * i + k] *= 1.5F;
        coarse.gaussians.centre[3 * i + 1] += 0.01F;
    }
    ffp_coarse_carry(&coarse, &before, &s.origin, &fine);
    for (int64_t i = 0; i < fine.count; i++) {
        assert_float_equal(fine.centre[3 * i], s.truth.centre[3 * i], 1e-5);
        assert_float_equal(fine.centre[3 * i + 1], s.truth.centre[3 * i + 1] + 0.01F, 1e-5);
        assert_float_equal(fine.scale[3 * i + 2], 1.5F * s.truth.scale[3 * i + 2], 1e-5);
        assert_float_equal(fine.albedo[3 * i], s.truth.albedo[3 * i], 1e-5);
        assert_float_equal(fine.opacity[i], s.truth.opacity[i], 1e-5);
    }
    ffp_gaussians_free(&before);
    ffp_gaussians_free(&fine);
    ffp_coarse_free(&coarse);
    scene_free(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_small_pictures_are_fitted_as_ever),
        cmocka_unit_test(test_levels_gain_at_seen_and_unseen_views),
        cmocka_unit_test(test_what_loses_is_dropped),
        cmocka_unit_test(test_threads_do_not_matter),
        cmocka_unit_test(test_stopping_ends_all_levels),
        cmocka_unit_test(test_reduced_pictures_show_the_same),
        cmocka_unit_test(test_pictures_are_cut_to_the_object),
        cmocka_unit_test(test_changes_are_carried),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
