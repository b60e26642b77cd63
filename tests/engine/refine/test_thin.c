// Thinning of the splats that eight views' pixels make of a ball.
// Labels: threads
#include <math.h>
#include <omp.h>
#include "core/base/alloc.h"
#include "core/base/vec.h"
#include "engine/refine/thin.h"
#include "engine/render/render.h"
#include "support.h"

enum { SIDE = 48, VIEWS = 8, AREA = SIDE * SIDE };
#define BALL 0.8F

typedef struct Set {
    FfpCapture capture;
    FfpGaussians gaussians;
    int64_t *pixel;
    real *trust;
} Set;

static FfpCamera camera_around(real azimuth) {
    FfpCamera c = {SIDE, SIDE, 1.37F * SIDE, 1.37F * SIDE, SIDE / 2.0F, SIDE / 2.0F, {0}};
    const real forward[3] = {-cosf(azimuth), -sinf(azimuth), 0}, down[3] = {0, 0, -1};
    real right[3];
    ffp_cross3(down, forward, right);
    for (int i = 0; i < 3; i++) {
        real *row = c.pose + 4 * i;
        row[0] = right[i], row[1] = down[i], row[2] = forward[i], row[3] = -3 * forward[i];
    }
    c.pose[15] = 1;
    return c;
}

// Where the ray of a pixel meets the ball; false beside it.
static bool meet(const FfpCamera *camera, int64_t pixel, real point[3]) {
    real d[3];
    const real o[3] = {camera->pose[3], camera->pose[7], camera->pose[11]};
    ffp_pixel_ray(camera, (real)(pixel % SIDE) + 0.5F, (real)(pixel / SIDE) + 0.5F, d);
    const real b = ffp_dot3(o, d), root = b * b - ffp_dot3(o, o) + BALL * BALL;
    for (int c = 0; c < 3 && root > 0; c++) point[c] = o[c] - (b + sqrtf(root)) * d[c];
    return root > 0;
}

// A splat as the classical initialisation has it: 0.425 pixels wide, flat on the ball.
static void put(FfpGaussians *g, int64_t i, const real point[3], const FfpCamera *camera) {
    real x, y, n[3] = {point[0] / BALL, point[1] / BALL, point[2] / BALL};
    const real width = 0.425F * ffp_project(camera, point, &x, &y) / camera->fx;
    const real q[4] = {1 + n[2], -n[1], n[0], 0}, length = sqrtf(2 + 2 * n[2]);
    for (int c = 0; c < 3; c++) {
        g->centre[3 * i + c] = point[c];
        g->scale[3 * i + c] = c < 2 ? width : 0.1F * width;
        g->albedo[3 * i + c] = 0.5F;
    }
    for (int c = 0; c < 4; c++) g->rotation[4 * i + c] = q[c] / length;
    g->opacity[i] = 0.924F;
    g->roughness[i] = 0.5F;
}

// The views are VIEWS steps round the ball; those from VIEWS on are the first ones again.
static Set set_new(int views) {
    Set s = {.capture = {.n_views = views, .views = ffp_alloc((size_t)views, sizeof(FfpView))},
             .gaussians = ffp_gaussians_new((int64_t)views * AREA),
             .pixel = ffp_alloc((size_t)views * AREA, sizeof(int64_t)),
             .trust = ffp_alloc((size_t)views * AREA, sizeof(real))};
    int64_t count = 0;
    for (int v = 0; v < views; v++) {
        FfpCamera *camera = &s.capture.views[v].camera;
        *camera = camera_around((real)(v % VIEWS) * 6.2831853F / VIEWS);
        for (int64_t p = 0; p < AREA; p++) {
            real point[3];
            if (!meet(camera, p, point)) continue;
            s.pixel[count] = v * AREA + p;
            put(&s.gaussians, count++, point, camera);
        }
    }
    s.gaussians.count = count;
    return s;
}

static void set_free(Set *s) {
    ffp_gaussians_free(&s->gaussians);
    ffp_free(s->capture.views), ffp_free(s->pixel), ffp_free(s->trust);
}

static int64_t thin(Set *s, double layers) {
    return ffp_thin(&s->gaussians, s->pixel, &s->capture, s->trust, layers);
}

static void assert_same(const FfpGaussians *a, const FfpGaussians *b) {
    assert_int_equal(a->count, b->count);
    assert_memory_equal(a->centre, b->centre, sizeof(real) * 3 * (size_t)a->count);
    assert_memory_equal(a->scale, b->scale, sizeof(real) * 3 * (size_t)a->count);
    assert_memory_equal(a->albedo, b->albedo, sizeof(real) * 3 * (size_t)a->count);
}

// Mean and least opacity of the pixels whose eight neighbours the ball fills too.
static void look(const Set *s, int view, double *mean, double *least) {
    const FfpRenderSettings settings = ffp_render_defaults();
    const FfpCamera *camera = &s->capture.views[view].camera;
    FfpRaster *raster = ffp_raster_new();
    FfpGbuffer gbuffer = ffp_gbuffer_new(SIDE, SIDE);
    int inside = 0;
    real point[3];
    *mean = 0, *least = 1;
    ffp_rasterise(raster, &s->gaussians, camera, &settings, &gbuffer);
    for (int p = SIDE + 1; p < AREA - SIDE - 1; p++) {
        if (!meet(camera, p - SIDE - 1, point) || !meet(camera, p - SIDE + 1, point) ||
            !meet(camera, p + SIDE - 1, point) || !meet(camera, p + SIDE + 1, point))
            continue;
        *mean += gbuffer.opacity[p], inside++;
        *least = fmin(*least, gbuffer.opacity[p]);
    }
    *mean /= inside;
    ffp_gbuffer_free(&gbuffer);
    ffp_raster_free(raster);
}

static void test_fewer_splats_cover_the_ball(void **state) {
    (void)state;
    Set all = set_new(VIEWS), thinned = set_new(VIEWS);
    const int64_t left_out = thin(&thinned, 1);
    assert_int_equal(thinned.gaussians.count, all.gaussians.count - left_out);
    assert_true(5 * thinned.gaussians.count < 3 * all.gaussians.count);
    for (int v = 0; v < VIEWS; v++) {
        double mean[2], least[2];
        look(&all, v, &mean[0], &least[0]);
        look(&thinned, v, &mean[1], &least[1]);
        assert_true(fabs(mean[1] - mean[0]) < 0.01);
        assert_true(least[1] > least[0] - 0.05);
    }
    set_free(&all), set_free(&thinned);
}

static void test_more_layers_keep_more(void **state) {
    (void)state;
    int64_t before = 0;
    for (int layers = 1; layers <= 4; layers++) {
        Set s = set_new(VIEWS);
        thin(&s, layers < 4 ? layers : 0);
        assert_true(s.gaussians.count > before);
        before = s.gaussians.count;
        set_free(&s);
    }
    Set all = set_new(VIEWS);
    assert_int_equal(all.gaussians.count, before);
    all.gaussians.opacity[7] = 0; // cannot be seen
    assert_int_equal(thin(&all, 0), 1);
    set_free(&all);
}

// All views twice, or one of them: what is left is what the views alone leave.
static void test_views_given_twice_add_nothing(void **state) {
    (void)state;
    for (int layers = 0; layers <= 2; layers++) {
        Set once = set_new(VIEWS);
        thin(&once, layers);
        for (int views = VIEWS + 1; views <= 2 * VIEWS; views += VIEWS - 1) {
            Set again = set_new(views);
            thin(&again, layers);
            assert_same(&once.gaussians, &again.gaussians);
            set_free(&again);
        }
        set_free(&once);
    }
}

static void test_the_more_trusted_of_two_stays(void **state) {
    (void)state;
    Set s = set_new(VIEWS + 1);
    const int64_t last = s.gaussians.count - 1; // of the first view again
    s.trust[s.pixel[last]] = 0.5F;
    s.gaussians.albedo[3 * last] = 0.7F;
    const int64_t before = s.gaussians.count, left_out = thin(&s, 0);
    assert_int_equal(s.gaussians.count, before - left_out);
    assert_true(s.gaussians.albedo[3 * (s.gaussians.count - 1)] == 0.7F);
    set_free(&s);
}

static void test_any_number_of_threads_gives_the_same(void **state) {
    (void)state;
    Set one = set_new(VIEWS), three = set_new(VIEWS);
    const int threads = omp_get_max_threads();
    omp_set_num_threads(1);
    thin(&one, 1.5);
    omp_set_num_threads(3);
    thin(&three, 1.5);
    omp_set_num_threads(threads);
    assert_same(&one.gaussians, &three.gaussians);
    set_free(&one), set_free(&three);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_fewer_splats_cover_the_ball),
        cmocka_unit_test(test_more_layers_keep_more),
        cmocka_unit_test(test_views_given_twice_add_nothing),
        cmocka_unit_test(test_the_more_trusted_of_two_stays),
        cmocka_unit_test(test_any_number_of_threads_gives_the_same),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
