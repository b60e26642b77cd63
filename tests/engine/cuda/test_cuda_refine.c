// The fit on a device against the fit on the CPU: its parts, and the whole.
#include "ball.h"
#include "compare.h"
#include "core/base/alloc.h"
#include "core/base/log.h"
#include "core/capture/uploaded.h"
#include "engine/cuda/cuda.h"
#include "engine/refine/fit.h"
#include "engine/refine/pyramid.h"
#include "engine/refine/table.h"
#include "lab/baselines/scratch.h"
#include "support.h"

static const FfpDevice *device; // NULL: none is here

static const FfpDevice *device_or_skip(void) {
    if (!device) skip();
    return device;
}

static bool large(void) {
    return getenv("FFP_LARGE") != NULL;
}

static int64_t splats(void) {
    return large() ? 45001 : 333;
}

// Of an array of what the thread works on.
static real *host_copy(const real *from, size_t count) {
    real *to = ffp_alloc(count * sizeof *to + 1, 1);
    ffp_memory_download(to, from, count * sizeof *to);
    return to;
}

// |a - b| <= tolerance (1 + |a|), all of them. `there` is the device's.
static void check_array(const char *what, const real *here, const real *there, size_t count,
                        double tolerance) {
    const FfpDevice *before = ffp_device_use(device);
    real *back = host_copy(there, count);
    ffp_device_use(before);
    for (size_t i = 0; i < count; i++) {
        const double error = fabs((double)here[i] - (double)back[i]);
        if (error <= tolerance * (1 + fabs((double)here[i]))) continue;
        fail_msg("%s[%zu]: %.9g on the CPU, %.9g on the device", what, i, (double)here[i], (double)back[i]);
    }
    ffp_free(back);
}

// As a whole: Adam's steps are as long where a gradient is all rounding, so that single splats may go
// elsewhere.
static void check_fitted(const FfpGaussians *here, const FfpGaussians *there) {
    const FfpDevice *before = ffp_device_use(device);
    assert_true(here->count == there->count);
    for (int a = 0; a < FFP_ATTRIBUTES; a++) {
        const FfpAttribute x = ffp_attribute(here, a);
        assert_close(ffp_attribute(there, a).data, x.data, here->count * x.width, 0.01,
                     ffp_attributes[a].name);
    }
    ffp_device_use(before);
}

static void check_gaussians(const char *what, const FfpGaussians *here, const FfpGaussians *there,
                            double tolerance) {
    char text[64];
    assert_true(here->count == there->count);
    for (int a = 0; a < FFP_ATTRIBUTES; a++) {
        const FfpAttribute x = ffp_attribute(here, a);
        snprintf(text, sizeof text, "%s %s", what, ffp_attributes[a].name);
        check_array(text, x.data, ffp_attribute(there, a).data, (size_t)here->count * (size_t)x.width,
                    tolerance);
    }
}

static FfpGaussians random_set(int64_t count, uint64_t seed) {
    FfpGaussians g = ffp_gaussians_new(count);
    FfpRng rng = ffp_rng(seed, 1);
    for (int a = 0; a < FFP_ATTRIBUTES; a++) {
        const FfpAttribute x = ffp_attribute(&g, a);
        for (int64_t i = 0; i < count * x.width; i++) x.data[i] = (real)ffp_rng_normal(&rng);
    }
    return g;
}

// Gaussians with the ends of every map among them: opacity 0 and 1, a scale of 0, a rotation of length 0.
static FfpGaussians odd_ball(void) {
    FfpGaussians g = ball_disturbed(splats());
    g.opacity[0] = 0, g.opacity[1] = 1, g.roughness[2] = 0, g.scale[9] = 0;
    for (int k = 0; k < 4; k++) g.rotation[16 + k] = 0, g.rotation[20 + k] *= 3;
    for (int64_t i = 0; i < 3 * g.count; i++) g.scattered[i] = 0.01F * (real)(i % 7);
    g.scatters = true;
    return g;
}

static void check_maps(bool local, bool flat) {
    FfpGaussians g = odd_ball(), decoded = ffp_gaussians_new(g.count), grad = random_set(g.count, 3);
    FfpParameters p = ffp_parameters_new(&g, local, flat);
    ffp_parameters_decode(&p, &decoded);
    ffp_device_use(device);
    FfpGaussians g_there = ffp_gaussians_uploaded(&g), decoded_there = ffp_gaussians_new(g.count);
    FfpGaussians grad_there = ffp_gaussians_uploaded(&grad);
    FfpParameters p_there = ffp_parameters_new(&g_there, local, flat);
    for (int a = 0; a < FFP_ATTRIBUTES; a++) // poison
        ffp_memory_copy(ffp_attribute(&decoded_there, a).data, ffp_attribute(&grad_there, a).data,
                        (size_t)g.count * (size_t)ffp_attribute(&g, a).width * sizeof(real));
    ffp_parameters_decode(&p_there, &decoded_there);
    ffp_parameters_pull_back(&p_there, &decoded_there, &grad_there);
    ffp_device_use(NULL);
    ffp_parameters_pull_back(&p, &decoded, &grad);
    const size_t n = (size_t)g.count;
    check_gaussians("number", &p.numbers, &p_there.numbers, 1e-5);
    check_array("origin", p.origin, p_there.origin, 3 * n, 1e-6);
    check_array("frame", p.frame, p_there.frame, 4 * n, 1e-6);
    check_array("unit", p.unit, p_there.unit, n, 1e-6);
    check_gaussians("decoded", &decoded, &decoded_there, 1e-5);
    check_gaussians("gradient", &grad, &grad_there, 1e-5);
    ffp_gaussians_free(&g), ffp_gaussians_free(&decoded), ffp_gaussians_free(&grad);
    ffp_parameters_free(&p);
    ffp_device_use(device);
    ffp_gaussians_free(&g_there), ffp_gaussians_free(&decoded_there), ffp_gaussians_free(&grad_there);
    ffp_parameters_free(&p_there);
    ffp_device_use(NULL);
}

static void test_maps(void **state) {
    (void)state;
    device_or_skip();
    check_maps(true, false);
    check_maps(false, false);
    check_maps(false, true);
}

static void test_averages(void **state) {
    (void)state;
    device_or_skip();
    FfpGaussians g = ball_disturbed(splats()), mean = random_set(g.count, 4);
    FfpParameters p = ffp_parameters_new(&g, true, false);
    ffp_device_use(device);
    FfpGaussians g_there = ffp_gaussians_uploaded(&g), mean_there = ffp_gaussians_uploaded(&mean);
    FfpParameters p_there = ffp_parameters_new(&g_there, true, false);
    ffp_parameters_average(&p_there, 0.3F, &mean_there);
    ffp_device_use(NULL);
    ffp_parameters_average(&p, 0.3F, &mean);
    check_gaussians("mean of numbers", &mean, &mean_there, 1e-5);
    ffp_gaussians_free(&g), ffp_gaussians_free(&mean);
    ffp_parameters_free(&p);
    ffp_device_use(device);
    ffp_gaussians_free(&g_there), ffp_gaussians_free(&mean_there);
    ffp_parameters_free(&p_there);
    ffp_device_use(NULL);
}

typedef struct Run { // some steps along given gradients
    FfpParameters parameters;
    FfpGaussianAdam mover;
} Run;

static Run run_steps(const FfpGaussians *start, const FfpRefineSettings *settings) {
    enum { STEPS = 5 };
    const FfpDevice *there = ffp_device_use(NULL);
    FfpGaussians host = ffp_gaussians_copy(start);
    ffp_device_use(there);
    FfpGaussians g = ffp_gaussians_uploaded(&host);
    Run run = {.parameters = ffp_parameters_new(&g, true, false)};
    run.mover = ffp_gaussian_adam_new(&run.parameters, settings);
    for (int step = 0; step < STEPS; step++) {
        ffp_device_use(NULL);
        FfpGaussians slope = random_set(host.count, 10 + (uint64_t)step);
        ffp_device_use(there);
        FfpGaussians grad = ffp_gaussians_uploaded(&slope);
        ffp_gaussian_adam_step(&run.mover, &run.parameters, &grad, settings, (double)step / STEPS);
        ffp_gaussians_free(&grad);
        ffp_device_use(NULL);
        ffp_gaussians_free(&slope);
        ffp_device_use(there);
    }
    ffp_gaussians_free(&g);
    ffp_device_use(NULL);
    ffp_gaussians_free(&host);
    ffp_device_use(there);
    return run;
}

static void free_run(Run *run) {
    ffp_parameters_free(&run->parameters);
    ffp_gaussian_adam_free(&run->mover);
}

static void check_runs(const FfpRefineSettings *settings) {
    FfpGaussians start = ball_disturbed(splats());
    Run here = run_steps(&start, settings);
    ffp_device_use(device);
    Run there = run_steps(&start, settings), again = run_steps(&start, settings);
    const size_t n = (size_t)start.count;
    real *once = host_copy(there.parameters.numbers.roughness, n),
         *twice = host_copy(again.parameters.numbers.roughness, n);
    assert_memory_equal(once, twice, n * sizeof(real));
    ffp_device_use(NULL);
    ffp_free(once), ffp_free(twice);
    check_gaussians("moved", &here.parameters.numbers, &there.parameters.numbers, 1e-5);
    check_gaussians("mean", &here.mover.mean, &there.mover.mean, 1e-5);
    check_gaussians("square", &here.mover.square, &there.mover.square, 1e-5);
    check_gaussians("start", &here.mover.start, &there.mover.start, 1e-5);
    check_array("shared", here.mover.shared, there.mover.shared, FFP_SHARED_NUMBERS, 1e-5);
    assert_true((here.mover.shared[FFP_SHARED_MOVED] != 0) == (settings->rates.shared_roughness > 0));
    free_run(&here);
    ffp_gaussians_free(&start);
    ffp_device_use(device);
    free_run(&there), free_run(&again);
    ffp_device_use(NULL);
}

static void test_moves(void **state) {
    (void)state;
    device_or_skip();
    FfpRefineSettings settings = ffp_polish_defaults(5);
    check_runs(&settings);
    settings.rates.shared_roughness = 0;
    check_runs(&settings);
    for (int a = 0; a < FFP_ATTRIBUTES; a++) settings.rates.pull[a] = 0;
    settings.rates.shared_roughness = 0.1F;
    check_runs(&settings);
}

// Number i of the table of summed areas, which a pattern of one colour has none of.
static double summed_at(const FfpSummed *summed, size_t i) {
    const size_t entry = i / FFP_SUMMED_CHANNELS, c = i % FFP_SUMMED_CHANNELS;
    const size_t x = entry % ((size_t)summed->width + 1), y = entry / ((size_t)summed->width + 1);
    if (summed->sum) return summed->sum[i];
    return c < 3 ? summed->colour[c] * (double)(x * y) : 0;
}

static void check_summed(int width, int height) {
    FfpRng rng = ffp_rng(7, 1);
    FfpImage image = ffp_image_new(width, height, 3);
    for (int i = 0; i < width * height * 3; i++) image.data[i] = (real)ffp_rng_uniform(&rng);
    FfpSummed here = ffp_pattern_summed(&image);
    ffp_device_use(device);
    FfpImage image_there = image;
    image_there.data = ffp_memory_uploaded(image.data, (size_t)(width * height * 3), sizeof(real));
    FfpSummed there = ffp_pattern_summed(&image_there);
    assert_true(there.width == width && there.height == height);
    const size_t count = FFP_SUMMED_CHANNELS * (size_t)(width + 1) * (size_t)(height + 1);
    double *back = ffp_alloc(count * sizeof *back, 1);
    ffp_memory_download(back, there.sum, count * sizeof *back);
    for (size_t i = 0; i < count; i++)
        assert_true(fabs(back[i] - summed_at(&here, i)) <= 1e-13 * summed_at(&here, i));
    ffp_image_free(&image_there);
    ffp_summed_free(&there);
    ffp_device_use(NULL);
    ffp_image_free(&image);
    ffp_summed_free(&here);
    ffp_free(back);
}

static void test_summed(void **state) {
    (void)state;
    device_or_skip();
    check_summed(1, 1);
    check_summed(37, 19);
    check_summed(64, 3);
    check_summed(97, 66);
    if (large()) check_summed(1920, 1080);
}

static void test_what_a_device_cannot(void **state) {
    (void)state;
    device_or_skip();
    FfpGaussians g = {.count = 5};
    FfpCapture c = {.folder = "somewhere"};
    FfpRefineSettings s = ffp_polish_defaults(4);
    FfpRefineResult result;
    FfpError err = {0};
    ffp_device_use(device);
    const FfpGrowth growth = {0};
    s.growth = &growth;
    assert_false(ffp_refine(&g, &c, NULL, 0, &s, &result, &err));
    assert_non_null(strstr(err.text, "density"));
    s = ffp_refine_defaults(), s.steps = 4;
    assert_false(ffp_refine(&g, &c, NULL, 0, &s, &result, &err));
    assert_non_null(strstr(err.text, "smoothing"));
    const FfpScratchSettings scratch = ffp_scratch_defaults(false);
    assert_false(ffp_scratch_gaussians(&g, &c, &scratch, &err));
    assert_non_null(strstr(err.text, "CPU"));
    FfpView view = {.camera = {.width = 300, .height = 100}};
    c.views = &view, c.n_views = 1;
    const int64_t pixel[5] = {0};
    const FfpOrigin origin = {1, 300, 100, pixel};
    s.smooth = 0;
    assert_false(ffp_refine_pyramid(&g, &origin, &c, NULL, 0, &s, &result, &err));
    assert_non_null(strstr(err.text, "pixels"));
    ffp_device_use(NULL);
}

enum { ROUNDS = 3, VIEWS = 2 };
typedef struct Fitted {
    double loss[ROUNDS], psnr[ROUNDS];
    FfpRefineResult result;
} Fitted;

// Losses and PSNR of the rounds, as the fit reports them.
static Fitted fit(FfpGaussians *g, const FfpCapture *c) {
    Fitted f = {.result = {0}};
    FfpError err = {0};
    FfpRefineSettings s = ffp_polish_defaults(ROUNDS * VIEWS);
    s.quiet = true, s.measure = true, s.shadow_looks = 2;
    s.metrics = tmpfile();
    if (!ffp_refine(g, c, ball_patterns, BALL_PATTERNS, &s, &f.result, &err)) fail_msg("%s", err.text);
    rewind(s.metrics);
    for (int r = 0; r < ROUNDS; r++)
        assert_int_equal(fscanf(s.metrics,
                                "{\"step\": %*d, \"seconds\": %*f, \"loss\": %lf, \"psnr\": %lf, "
                                "\"gaussians\": %*d}\n",
                                &f.loss[r], &f.psnr[r]),
                         2);
    fclose(s.metrics);
    return f;
}

static void test_a_fit_is_the_same(void **state) {
    (void)state;
    device_or_skip();
    if (!device->render || !device->loss) skip();
    const int64_t count = large() ? 20000 : 200;
    FfpCapture c =
        large() ? ball_capture(count, VIEWS, 128, 100, 256) : ball_capture(count, VIEWS, 24, 20, 32);
    FfpGaussians here = ball_disturbed(count);
    ffp_device_use(device);
    FfpCapture c_there = ffp_capture_uploaded(&c, NULL, 0);
    FfpGaussians there = ffp_gaussians_uploaded(&here);
    const Fitted b = fit(&there, &c_there);
    ffp_device_use(NULL);
    const Fitted a = fit(&here, &c);
    for (int r = 0; r < ROUNDS; r++) {
        print_message("round %d: loss %.6f %.6f, PSNR %.4f %.4f\n", r, a.loss[r], b.loss[r], a.psnr[r],
                      b.psnr[r]);
        assert_true(fabs(a.loss[r] - b.loss[r]) <= 1e-3 * a.loss[r]);
        assert_true(fabs(a.psnr[r] - b.psnr[r]) <= 0.02);
    }
    assert_true(a.result.dropped == b.result.dropped && b.result.steps == ROUNDS * VIEWS);
    assert_true(fabs(a.result.psnr_before - b.result.psnr_before) <= 0.02);
    assert_true(fabs(a.result.psnr_after - b.result.psnr_after) <= 0.02);
    check_fitted(&here, &there);
    ffp_gaussians_free(&here);
    ffp_capture_free(&c);
    ffp_device_use(device);
    ffp_gaussians_free(&there);
    ffp_capture_free(&c_there);
    ffp_device_use(NULL);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_maps),
        cmocka_unit_test(test_averages),
        cmocka_unit_test(test_moves),
        cmocka_unit_test(test_summed),
        cmocka_unit_test(test_what_a_device_cannot),
        cmocka_unit_test(test_a_fit_is_the_same),
    };
    FfpError err = {0};
    device = ffp_cuda_device(&err);
    print_message("%s\n", device ? ffp_cuda_describe() : err.text);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
