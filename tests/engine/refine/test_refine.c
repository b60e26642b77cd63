// Fits on a small scene of splats that were drawn by the renderer itself, so that the truth is known.
// Labels: threads
#include <omp.h>
#include "core/base/alloc.h"
#include "core/base/rng.h"
#include "core/base/vec.h"
#include "engine/loss/metrics.h"
#include "engine/refine/fit.h"
#include "engine/refine/neighbours.h"
#include "engine/refine/refine.h"
#include "engine/render/pass.h"
#include "looking.h"
#include "stopped.h"
#include "support.h"

#define SIDE 40
#define VIEWS 4
#define SPLATS 400

enum { BLACK, WHITE, STRIPES, PATTERNS };
static const int all_patterns[] = {BLACK, WHITE, STRIPES};

static FfpCamera look_at_origin(real azimuth, real height, real distance, int side) {
    const real eye[3] = {distance * (real)cos(azimuth), distance * (real)sin(azimuth), height};
    return looking_at_origin(eye, side, side, (real)side * 1.3F);
}

// Splats on a ball of radius 0.6, flat along its surface, of changing colours and one roughness.
static FfpGaussians ball_of_roughness(real roughness) {
    FfpGaussians g = ffp_gaussians_new(SPLATS);
    for (int64_t i = 0; i < SPLATS; i++) {
        const real z = 1 - 2 * ((real)i + 0.5F) / SPLATS, a = 2.3999632F * (real)i;
        const real r = (real)sqrt(1 - z * z), n[3] = {r * (real)cos(a), r * (real)sin(a), z};
        const real q[4] = {1 + n[2], -n[1], n[0], 0}; // the z axis onto n
        for (int k = 0; k < 3; k++) {
            g.centre[3 * i + k] = 0.6F * n[k];
            g.scale[3 * i + k] = k < 2 ? 0.05F : 0.005F;
            g.albedo[3 * i + k] = 0.5F + 0.3F * n[(k + 1) % 3];
            g.ambient[3 * i + k] = 0.1F + 0.05F * n[k];
        }
        for (int k = 0; k < 4; k++) g.rotation[4 * i + k] = q[k] / (real)sqrt(2 + 2 * n[2]);
        g.opacity[i] = 0.95F;
        g.roughness[i] = roughness;
    }
    return g;
}

static FfpGaussians ball(void) {
    return ball_of_roughness(0.6F);
}

static FfpImage pattern_image(int pattern) {
    FfpImage image = ffp_image_new(32, 32, 3);
    for (int i = 0; i < 32 * 32 * 3; i++)
        image.data[i] = pattern == WHITE ? 1 : pattern == STRIPES ? (real)(i / 3 / 4 % 2) : 0;
    return image;
}

static void photograph(FfpView *view, const FfpGaussians *truth, const FfpCapture *capture) {
    const FfpRenderSettings settings = ffp_render_defaults();
    FfpRaster *raster = ffp_raster_new();
    FfpGbuffer gbuffer = ffp_gbuffer_new(SIDE, SIDE);
    view->images = ffp_alloc(PATTERNS, sizeof *view->images);
    view->coverage = ffp_image_new(SIDE, SIDE, 1);
    for (int p = 0; p < PATTERNS; p++) {
        FfpSummed light = ffp_summed_new(&capture->patterns[p].image);
        view->images[p] = ffp_render_view(truth, &view->camera, &view->projector, capture->intensity,
                                          p == BLACK ? NULL : &light, &settings);
        ffp_image_to_linear(&view->images[p]);
        ffp_summed_free(&light);
    }
    ffp_rasterise(raster, truth, &view->camera, &settings, &gbuffer);
    for (int i = 0; i < SIDE * SIDE; i++) view->coverage.data[i] = gbuffer.opacity[i] > 0.5F;
    ffp_gbuffer_free(&gbuffer);
    ffp_raster_free(raster);
}

// A ball from all around, and a fifth view from between that fits never see.
static FfpCapture capture_of(const FfpGaussians *truth) {
    FfpCapture c = {.n_patterns = PATTERNS,
                    .n_views = VIEWS,
                    .patterns = ffp_alloc(PATTERNS, sizeof *c.patterns),
                    .views = ffp_alloc(VIEWS + 1, sizeof *c.views),
                    .black = BLACK,
                    .white = WHITE,
                    .intensity = {4, 4, 4},
                    .radius = 1};
    strcpy(c.folder, "ball");
    for (int p = 0; p < PATTERNS; p++) c.patterns[p].image = pattern_image(p);
    for (int v = 0; v <= VIEWS; v++) {
        const real azimuth = (real)(v < VIEWS ? v : 0.5) * 6.2831853F / VIEWS;
        c.views[v].camera = look_at_origin(azimuth, 0.3F, 2.5F, SIDE);
        c.views[v].projector = look_at_origin(azimuth + 0.2F, 1, 2, 32);
        photograph(&c.views[v], truth, &c);
    }
    return c;
}

static FfpCapture ball_capture(void) {
    FfpGaussians truth = ball();
    const FfpCapture c = capture_of(&truth);
    ffp_gaussians_free(&truth);
    return c;
}

static void free_capture(FfpCapture *c) {
    c->n_views = VIEWS + 1;
    ffp_capture_free(c);
}

// The truth with errors in everything.
static FfpGaussians disturbed(void) {
    FfpGaussians g = ball();
    FfpRng rng = ffp_rng(5, 1);
    for (int64_t i = 0; i < 3 * g.count; i++) {
        g.centre[i] += 0.005F * ffp_rng_normal(&rng);
        g.scale[i] *= (real)exp(0.2F * ffp_rng_normal(&rng));
        g.albedo[i] = fmin(fmax(g.albedo[i] + 0.1F * ffp_rng_normal(&rng), 0.02F), 0.98F);
        g.ambient[i] = fmax(g.ambient[i] + 0.03F * ffp_rng_normal(&rng), 0.01F);
    }
    return g;
}

static double psnr_of_view(const FfpCapture *c, const FfpGaussians *g, int view, int pattern) {
    const FfpRenderSettings settings = ffp_render_defaults();
    const FfpView *v = &c->views[view];
    FfpSummed light = ffp_summed_new(&c->patterns[pattern].image);
    FfpImage drawn = ffp_render_view(g, &v->camera, &v->projector, c->intensity,
                                     pattern == BLACK ? NULL : &light, &settings);
    FfpImage truth = ffp_image_copy(&v->images[pattern]);
    ffp_image_to_srgb(&truth);
    const double psnr = ffp_psnr(&drawn, &truth);
    ffp_image_free(&drawn);
    ffp_image_free(&truth);
    ffp_summed_free(&light);
    return psnr;
}

static void test_a_fit_gains_on_seen_and_unseen_views(void **state) {
    (void)state;
    FfpCapture c = ball_capture();
    FfpGaussians g = disturbed();
    FfpRefineSettings s = ffp_refine_defaults();
    FfpRefineResult result;
    s.steps = 80;
    const double unseen = psnr_of_view(&c, &g, VIEWS, STRIPES);
    assert_true(ffp_refine(&g, &c, all_patterns, PATTERNS, &s, &result, NULL));
    assert_int_equal(result.steps, 80);
    assert_true(result.psnr_after > result.psnr_before + 4);
    assert_true(psnr_of_view(&c, &g, VIEWS, STRIPES) > unseen + 1);
    for (int64_t i = 0; i < 3 * g.count; i++) {
        assert_true(g.scale[i] > 0);
        assert_true(g.albedo[i] > 0 && g.albedo[i] < 1);
    }
    ffp_gaussians_free(&g);
    free_capture(&c);
}

static void test_a_polish_gains_in_few_steps(void **state) {
    (void)state;
    FfpCapture c = ball_capture();
    FfpGaussians g = disturbed();
    const FfpRefineSettings s = ffp_polish_defaults(20);
    FfpRefineResult result;
    const double seen = psnr_of_view(&c, &g, 0, STRIPES), unseen = psnr_of_view(&c, &g, VIEWS, STRIPES);
    assert_true(ffp_refine(&g, &c, all_patterns, PATTERNS, &s, &result, NULL));
    assert_int_equal(result.steps, 20);
    assert_true(psnr_of_view(&c, &g, 0, STRIPES) > seen + 2);
    assert_true(psnr_of_view(&c, &g, VIEWS, STRIPES) > unseen);
    ffp_gaussians_free(&g);
    free_capture(&c);
}

static void test_numbers_are_averaged(void **state) {
    (void)state;
    enum { SETS = 3 };
    FfpGaussians g = disturbed(), mean = ffp_gaussians_new(g.count);
    FfpParameters p = ffp_parameters_new(&g, true, false);
    double sum = 0, sum_of_last = 0;
    for (int n = 1; n <= SETS; n++) {
        for (int64_t i = 0; i < 4 * g.count; i++) p.numbers.rotation[i] = (real)sin(n + 0.3 * (double)i);
        p.numbers.opacity[g.count - 1] = (real)(n * n);
        sum += (double)p.numbers.rotation[7], sum_of_last += n * n;
        ffp_parameters_average(&p, (real)(1 / (double)n), &mean);
    }
    assert_float_equal(mean.rotation[7], sum / SETS, 1e-6);
    assert_float_equal(mean.opacity[g.count - 1], sum_of_last / SETS, 1e-6);
    assert_float_equal(mean.albedo[5], p.numbers.albedo[5], 1e-6);
    ffp_parameters_free(&p);
    ffp_gaussians_free(&mean);
    ffp_gaussians_free(&g);
}

static FfpGaussians polished(const FfpCapture *c, const FfpRefineSettings *settings) {
    FfpRefineResult result;
    FfpGaussians g = disturbed();
    assert_true(ffp_refine(&g, c, all_patterns, PATTERNS, settings, &result, NULL));
    assert_false(result.dropped);
    return g;
}

// At rates that do not fall, shorter fits are the beginnings of longer ones: the mean over four steps is that
// of what four fits end with, and later ones count for more.
static void test_a_polish_returns_the_mean_of_its_last_steps(void **state) {
    (void)state;
    enum { STEPS = 16, LAST = 4 };
    const double weight[LAST] = {20 / 35.0, 10 / 35.0, 4 / 35.0, 1 / 35.0}; // the last one's first; cubic
    FfpCapture c = ball_capture();
    FfpRefineSettings s = ffp_polish_defaults(STEPS);
    assert_true(s.mean > 0 && s.mean_late == 3);
    s.decay = s.centre_decay = 1;
    s.mean = (LAST + 0.5) / STEPS;
    FfpGaussians mean = polished(&c, &s), last[LAST];
    for (int i = 0; i < LAST; i++) {
        s.steps = STEPS - i, s.mean = 1.5 / (double)s.steps;
        last[i] = polished(&c, &s);
    }
    double moved = 0;
    for (int64_t i = 0; i < 3 * mean.count; i++) {
        double centre = 0, log_scale = 0;
        for (int k = 0; k < LAST; k++)
            centre += weight[k] * (double)last[k].centre[i],
                log_scale += weight[k] * log((double)last[k].scale[i]);
        assert_float_equal(mean.centre[i], centre, 1e-5);
        assert_float_equal(log((double)mean.scale[i]), log_scale, 1e-4);
        moved = worse(moved, fabs((double)last[0].scale[i] / (double)last[LAST - 1].scale[i] - 1));
    }
    assert_true(moved > 0.01);
    for (int i = 0; i < LAST; i++) ffp_gaussians_free(&last[i]);
    ffp_gaussians_free(&mean);
    free_capture(&c);
}

// (1 + R) / 2 solved for u, by Gauss.
static void solve_coupled(double r[3][3], double u[3]) {
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) r[i][j] = (r[i][j] + (i == j)) / 2;
    }
    for (int i = 0; i < 3; i++) {
        for (int k = i + 1; k < 3; k++) {
            const double f = r[k][i] / r[i][i];
            for (int j = i; j < 3; j++) r[k][j] -= f * r[i][j];
            u[k] -= f * u[i];
        }
    }
    for (int i = 2; i >= 0; i--) {
        for (int j = i + 1; j < 3; j++) u[i] -= r[i][j] * u[j];
        u[i] /= r[i][i];
    }
}

// The step's change of the centre's numbers; all moments are the caller's.
static void coupled_step(const FfpRefineSettings *s, int step, const real *g, double mean[3],
                         double second[3][3], double out[3]) {
    const double b1 = (double)s->beta1, b2 = (double)s->beta2;
    const double c1 = 1 - pow(b1, step), c2 = 1 - pow(b2, step);
    double r[3][3];
    for (int i = 0; i < 3; i++) {
        mean[i] = b1 * mean[i] + (1 - b1) * (double)g[i];
        for (int j = 0; j < 3; j++) second[i][j] = b2 * second[i][j] + (1 - b2) * (double)(g[i] * g[j]);
    }
    for (int i = 0; i < 3; i++) {
        out[i] = mean[i] / c1 / sqrt(second[i][i] / c2);
        for (int j = 0; j < 3; j++) r[i][j] = second[i][j] / sqrt(second[i][i] * second[j][j]);
    }
    solve_coupled(r, out);
    for (int i = 0; i < 3; i++) out[i] *= (double)s->rates.rate[FFP_CENTRE];
}

static void test_centres_are_coupled(void **state) {
    (void)state;
    enum { STEPS = 6 };
    FfpRefineSettings s = ffp_polish_defaults(STEPS);
    assert_true(s.coupled);
    s.decay = s.centre_decay = 1;
    s.rates.pull[FFP_CENTRE] = 0;
    FfpGaussians g = ball(), grad = ffp_gaussians_new(g.count);
    FfpParameters p = ffp_parameters_new(&g, true, false);
    FfpGaussianAdam adam_state = ffp_gaussian_adam_new(&p, &s);
    double mean[SPLATS][3] = {{0}}, second[SPLATS][3][3] = {{{0}}}, x[SPLATS][3] = {{0}};
    FfpRng rng = ffp_rng(5, 1);
    for (int step = 1; step <= STEPS; step++) {
        for (int64_t i = 0; i < g.count; i++) {
            const real shared = ffp_rng_range(&rng, -1, 1);
            double move[3];
            for (int k = 0; k < 3; k++) grad.centre[3 * i + k] = (real)(k + 1) * shared;
            grad.centre[3 * i + i % 3] += ffp_rng_range(&rng, -1, 1);
            coupled_step(&s, step, grad.centre + 3 * i, mean[i], second[i], move);
            for (int k = 0; k < 3; k++) x[i][k] -= move[k];
        }
        ffp_gaussian_adam_step(&adam_state, &p, &grad, &s, 0);
    }
    for (int64_t i = 0; i < 3 * g.count; i++) assert_float_equal(p.numbers.centre[i], x[i / 3][i % 3], 1e-4);
    ffp_gaussian_adam_free(&adam_state);
    ffp_parameters_free(&p);
    ffp_gaussians_free(&grad);
    ffp_gaussians_free(&g);
}

// Of a fit that goes astray at its end nothing of that end is kept.
static void test_the_mean_is_left_where_the_fit_goes_astray(void **state) {
    (void)state;
    FfpCapture c = ball_capture();
    FfpRefineSettings s = ffp_polish_defaults(40);
    for (int a = 0; a < FFP_ATTRIBUTES; a++) s.rates.rate[a] /= 4;
    s.decay = s.centre_decay = 100;
    FfpGaussians with = polished(&c, &s);
    s.mean = 0;
    FfpGaussians without = polished(&c, &s);
    for (int a = 0; a < FFP_ATTRIBUTES; a++) {
        const FfpAttribute x = ffp_attribute(&with, a), y = ffp_attribute(&without, a);
        assert_memory_equal(x.data, y.data, sizeof(real) * (size_t)x.width * (size_t)with.count);
    }
    ffp_gaussians_free(&with);
    ffp_gaussians_free(&without);
    free_capture(&c);
}

static void look_away(void *state, const FfpGaussians *gaussians, const FfpGaussians *grad,
                      const FfpCamera *camera) {
    (void)state, (void)gaussians, (void)grad, (void)camera;
}

// After the last step nothing can be seen any more.
static bool hide(void *state, int64_t step, FfpParameters *parameters, const FfpGaussians *gaussians,
                 FfpGaussianAdam *adam_state) {
    (void)gaussians, (void)adam_state;
    const bool due = step == *(const int64_t *)state;
    for (int64_t i = 0; due && i < parameters->numbers.count; i++) parameters->numbers.opacity[i] = -10;
    return due;
}

// The last round has the most dB, but its looks were at what was there before.
static void test_what_has_just_been_changed_is_no_result(void **state) {
    (void)state;
    FfpCapture c = ball_capture();
    FfpGaussians g = disturbed();
    int64_t steps = 6 * VIEWS;
    FfpRefineSettings s = ffp_polish_defaults(steps);
    FfpRefineResult result;
    const FfpGrowth growth = {&steps, look_away, hide};
    const double before = ffp_photographs_psnr(&g, &c, all_patterns, PATTERNS, &s.render);
    s.growth = &growth;
    s.pairs = false;
    s.mean = 0;
    s.rates.rate[FFP_CENTRE] = s.rates.rate[FFP_SCALE] = 0; // in the world's units, with growth
    assert_true(ffp_refine(&g, &c, all_patterns, PATTERNS, &s, &result, NULL));
    assert_int_equal(result.steps, steps);
    assert_true(ffp_photographs_psnr(&g, &c, all_patterns, PATTERNS, &s.render) > before + 1);
    ffp_gaussians_free(&g);
    free_capture(&c);
}

static int compare_reals(const void *a, const void *b) {
    const real x = *(const real *)a, y = *(const real *)b;
    return (x > y) - (x < y);
}

static real median_roughness(const FfpGaussians *g) {
    real sorted[SPLATS];
    memcpy(sorted, g->roughness, sizeof sorted);
    qsort(sorted, SPLATS, sizeof *sorted, compare_reals);
    return sorted[SPLATS / 2];
}

// Started at 0.6, in no more steps than a reconstruction takes.
static void test_a_polish_finds_the_roughness(void **state) {
    (void)state;
    const real truths[] = {0.35F, 0.6F};
    for (int i = 0; i < 2; i++) {
        FfpGaussians truth = ball_of_roughness(truths[i]), g = disturbed();
        FfpCapture c = capture_of(&truth);
        const FfpRefineSettings s = ffp_polish_defaults(40);
        FfpRefineResult result;
        assert_true(ffp_refine(&g, &c, all_patterns, PATTERNS, &s, &result, NULL));
        assert_float_equal(median_roughness(&g), truths[i], 0.03);
        ffp_gaussians_free(&g);
        ffp_gaussians_free(&truth);
        free_capture(&c);
    }
}

// Of a polish for any number of threads.
static void test_the_same_seed_gives_the_same_bits(void **state) {
    (void)state;
    enum { FITS = 6 };
    static const int threads[FITS] = {0, 0, 1, 2, 3, 4};
    FfpCapture c = ball_capture();
    FfpRefineResult result;
    FfpGaussians g[FITS];
    const int before = omp_get_max_threads();
    for (int i = 0; i < FITS; i++) {
        FfpRefineSettings s = threads[i] ? ffp_polish_defaults(11) : ffp_refine_defaults();
        s.steps = 11;
        g[i] = disturbed();
        if (threads[i]) omp_set_num_threads(threads[i]);
        assert_true(ffp_refine(&g[i], &c, all_patterns, PATTERNS, &s, &result, NULL));
        omp_set_num_threads(before);
    }
    for (int i = 1; i < FITS; i++)
        for (int a = 0; i != 2 && a < FFP_ATTRIBUTES; a++) {
            const FfpAttribute x = ffp_attribute(&g[i], a), y = ffp_attribute(&g[i - 1], a);
            assert_memory_equal(x.data, y.data, sizeof(real) * (size_t)x.width * (size_t)g[i].count);
        }
    for (int i = 0; i < FITS; i++) ffp_gaussians_free(&g[i]);
    free_capture(&c);
}

// Eight views of a turntable and one more: opposites, whatever the order.
static void test_pairs_are_opposites(void **state) {
    (void)state;
    enum { COUNT = 9 };
    FfpView views[COUNT] = {0};
    const FfpCapture c = {.n_views = COUNT, .views = views};
    int order[COUNT] = {3, 0, 5, 2, 4, 7, 6, 1, 8}, seen[COUNT] = {0};
    for (int v = 0; v < 8; v++) views[v].camera = look_at_origin((real)v * 6.2831853F / 8, 1, 2, SIDE);
    views[8].camera = look_at_origin(0.1F, 1.4F, 0.3F, SIDE); // from above
    ffp_pair_opposites(&c, order);
    assert_int_equal(order[0], 3);
    assert_int_equal(order[1], 7);
    for (int i = 0; i < COUNT; i++) seen[order[i]]++;
    for (int v = 0; v < COUNT; v++) assert_int_equal(seen[v], 1);
    for (int i = 0; i + 1 < COUNT; i += 2) assert_int_equal((order[i] + 4) % 8, order[i + 1]);
}

typedef struct Fit {
    FfpGaussians *gaussians;
    const FfpCapture *capture;
    const FfpRefineSettings *settings;
    FfpRefineResult *result;
} Fit;

static bool refine_all(void *argument, FfpError *err) {
    const Fit *fit = argument;
    return ffp_refine(fit->gaussians, fit->capture, all_patterns, PATTERNS, fit->settings, fit->result, err);
}

static void test_stopping_keeps_the_start_and_limits_are_asked_for(void **state) {
    (void)state;
    FfpCapture c = ball_capture();
    FfpGaussians g = disturbed(), before = disturbed();
    FfpRefineSettings s = ffp_refine_defaults();
    FfpRefineResult result;
    FfpError err;
    assert_false(ffp_refine(&g, &c, all_patterns, PATTERNS, &s, &result, &err));
    assert_non_null(strstr(err.text, "limit"));
    s.steps = 100, s.may_stop = true;
    assert_true(run_stopped(refine_all, &(Fit){&g, &c, &s, &result}, &err));
    assert_true(result.stopped);
    assert_int_equal(result.steps, 0);
    for (int64_t i = 0; i < 3 * g.count; i++) assert_float_equal(g.centre[i], before.centre[i], 1e-6);
    FfpGaussians none = ffp_gaussians_new(0);
    assert_false(ffp_refine(&none, &c, all_patterns, PATTERNS, &s, &result, &err));
    assert_non_null(strstr(err.text, "no Gaussians"));
    ffp_gaussians_free(&none);
    ffp_gaussians_free(&before);
    ffp_gaussians_free(&g);
    free_capture(&c);
}

static void test_numbers_go_there_and_back(void **state) {
    (void)state;
    FfpGaussians g = disturbed(), back = ffp_gaussians_new(g.count);
    for (int local = 0; local < 2; local++) {
        FfpParameters p = ffp_parameters_new(&g, local, false);
        ffp_parameters_decode(&p, &back);
        for (int a = 0; a < FFP_ATTRIBUTES; a++) {
            const FfpAttribute was = ffp_attribute(&g, a), is = ffp_attribute(&back, a);
            for (int64_t i = 0; i < g.count * was.width; i++)
                assert_float_equal(was.data[i], is.data[i], 2e-6);
        }
        ffp_parameters_free(&p);
    }
    ffp_gaussians_free(&g);
    ffp_gaussians_free(&back);
}

// Row i of neighbours against all distances: each of another point, at its own distance, and as far as the
// k-th nearest is.
static void check_neighbours(const real *points, int count, int k, int i, const int64_t *row,
                             const real *squared) {
    static real sorted[500];
    int others = 0;
    for (int j = 0; j < count; j++) {
        if (j == i) continue;
        const real d[3] = {points[3 * i] - points[3 * j], points[3 * i + 1] - points[3 * j + 1],
                           points[3 * i + 2] - points[3 * j + 2]};
        const real distance = ffp_dot3(d, d);
        int at = others++;
        for (; at > 0 && sorted[at - 1] > distance; at--) sorted[at] = sorted[at - 1];
        sorted[at] = distance;
        for (int n = 0; n < k; n++)
            if (row[n] == j) assert_true(fabs(squared[n] - distance) <= 1e-6F * distance);
    }
    for (int n = 0; n < k; n++) {
        if (n >= others) {
            assert_true(row[n] == -1 && squared[n] == (real)INFINITY);
            continue;
        }
        assert_true(row[n] >= 0 && row[n] < count && row[n] != i);
        for (int m = 0; m < n; m++) assert_true(row[m] != row[n]);
        assert_true(fabs(squared[n] - sorted[n]) <= 1e-6F * sorted[n]);
    }
}

static void test_splats_do_not_become_needles(void **state) {
    (void)state;
    FfpGaussians g = ball(), out = ffp_gaussians_new(g.count);
    for (int local = 0; local < 2; local++) {
        FfpParameters p = ffp_parameters_new(&g, local, false);
        p.numbers.scale[0] += 0.5F, p.numbers.scale[5] += 5;
        ffp_parameters_decode(&p, &out);
        assert_float_equal(out.scale[0], 0.05 * exp(0.5), 1e-5);
        assert_float_equal(out.scale[5], local ? 3 * 0.05 : 0.005 * exp(5), 1e-3); // the third of the second
        ffp_parameters_free(&p);
    }
    ffp_gaussians_free(&g);
    ffp_gaussians_free(&out);
}

static void test_neighbours_are_those_of_brute_force(void **state) {
    (void)state;
    enum { COUNT = 500, K = 5 };
    static const int counts[] = {COUNT, 3};
    static real points[3 * COUNT], squared[K * COUNT];
    static int64_t neighbour[K * COUNT], alone[K * COUNT];
    FfpRng rng = ffp_rng(3, 1);
    for (int i = 0; i < 3 * COUNT; i++) points[i] = ffp_rng_range(&rng, -1.5F, 1.5F); // some outside
    for (int c = 0; c < 2; c++) {
        ffp_neighbours(points, counts[c], K, neighbour, squared);
        for (int i = 0; i < counts[c]; i++)
            check_neighbours(points, counts[c], K, i, neighbour + K * i, squared + K * i);
        ffp_neighbours(points, counts[c], K, alone, NULL);
        assert_memory_equal(alone, neighbour, sizeof *alone * K * (size_t)counts[c]);
    }
}

// Steps far too long destroy a fit. The initial state is then kept, bit for bit.
static void test_a_fit_that_loses_is_dropped(void **state) {
    (void)state;
    FfpCapture capture = ball_capture();
    FfpGaussians g = disturbed(), before = ffp_gaussians_copy(&g);
    FfpRefineSettings settings = ffp_polish_defaults(24);
    FfpRefineResult result;
    FfpError err = {0};
    settings.quiet = true;
    for (int a = 0; a < FFP_ATTRIBUTES; a++) settings.rates.rate[a] *= 300;
    assert_true(ffp_refine(&g, &capture, all_patterns, PATTERNS, &settings, &result, &err));
    assert_true(result.dropped);
    assert_int_equal(result.steps, 4 * VIEWS); // the first round, and three that lose
    assert_int_equal(result.gaussians, before.count);
    for (int a = 0; a < FFP_ATTRIBUTES; a++) {
        const FfpAttribute x = ffp_attribute(&g, a), y = ffp_attribute(&before, a);
        assert_memory_equal(x.data, y.data, sizeof(real) * (size_t)g.count * (size_t)x.width);
    }
    settings = ffp_polish_defaults(24);
    settings.quiet = true;
    const double psnr = ffp_photographs_psnr(&g, &capture, all_patterns, PATTERNS, &settings.render);
    assert_true(ffp_refine(&g, &capture, all_patterns, PATTERNS, &settings, &result, &err));
    assert_false(result.dropped);
    assert_true(ffp_photographs_psnr(&g, &capture, all_patterns, PATTERNS, &settings.render) > psnr + 1);
    ffp_gaussians_free(&g);
    ffp_gaussians_free(&before);
    free_capture(&capture);
}

typedef struct Quiet { // a fit, and how often it told of itself
    FfpGaussians g;
    FfpCapture capture;
    int told;
} Quiet;

// It is also asked whether to go on, in the stage that the caller is in: none here.
static bool count_telling(void *user, const FfpProgress *progress) {
    ((Quiet *)user)->told += progress->stage != NULL;
    return true;
}

static bool fit_quietly(void *argument, FfpError *err) {
    Quiet *q = argument;
    FfpRefineSettings settings = ffp_polish_defaults(8);
    FfpRefineResult result;
    settings.quiet = true;
    return ffp_refine(&q->g, &q->capture, all_patterns, PATTERNS, &settings, &result, err);
}

// In training a fit is a part of a step, which has its own progress.
static void test_a_quiet_fit_tells_nothing(void **state) {
    (void)state;
    Quiet q = {.g = disturbed(), .capture = ball_capture()};
    FfpContext context = {.settings = {.user = &q, .progress = count_telling}};
    FfpError err = {0};
    assert_true(ffp_call_run(&context, fit_quietly, &q, &err));
    assert_int_equal(q.told, 0);
    ffp_gaussians_free(&q.g);
    free_capture(&q.capture);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_fit_gains_on_seen_and_unseen_views),
        cmocka_unit_test(test_a_polish_gains_in_few_steps),
        cmocka_unit_test(test_numbers_are_averaged),
        cmocka_unit_test(test_a_polish_returns_the_mean_of_its_last_steps),
        cmocka_unit_test(test_centres_are_coupled),
        cmocka_unit_test(test_the_mean_is_left_where_the_fit_goes_astray),
        cmocka_unit_test(test_a_polish_finds_the_roughness),
        cmocka_unit_test(test_the_same_seed_gives_the_same_bits),
        cmocka_unit_test(test_pairs_are_opposites),
        cmocka_unit_test(test_stopping_keeps_the_start_and_limits_are_asked_for),
        cmocka_unit_test(test_numbers_go_there_and_back),
        cmocka_unit_test(test_neighbours_are_those_of_brute_force),
        cmocka_unit_test(test_splats_do_not_become_needles),
        cmocka_unit_test(test_what_has_just_been_changed_is_no_result),
        cmocka_unit_test(test_a_fit_that_loses_is_dropped),
        cmocka_unit_test(test_a_quiet_fit_tells_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
