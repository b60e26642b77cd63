// A reconstruction whose network and polish work on a device against one that is all the CPU's.
#include <string.h>
#include "compare.h"
#include "core/base/call.h"
#include "core/gaussians/gaussians.h"
#include "engine/loss/metrics.h"
#include "engine/network/network.h"
#include "engine/render/pass.h"
#include "ffprocams.h"
#include "ffprocams/lab.h"
#include "world/synth/synth.h"

static const FfpDevice *device;

static FfpCapture small_capture(void) {
    FfpCapture capture;
    FfpError err = {0};
    FfpSceneSpec spec = ffp_scene_defaults();
    spec.resolution = 40, spec.views = 3, spec.targets = 1, spec.lollipops = 1;
    spec.pattern_side = 64, spec.samples = 1, spec.ambient_rays = 1;
    if (!ffp_scene_make(&capture, &spec, &err)) fail_msg("%s", err.text);
    capture.n_views = 3; // without the new pose
    ffp_capture_estimate_bounds(&capture);
    return capture;
}

static FfpGaussians *reconstruct(const FfpCapture *capture, const FfpModel *model, int64_t polish,
                                 const FfpDevice *by) {
    FfpError err = {0};
    const FfpReconstruction how = {
        .size = sizeof how, .model = model, .polish = polish, .layers = FFP_LAYERS_AUTO};
    FfpContext context = {.device = by};
    FfpGaussians *gaussians = ffp_reconstruct(&context, capture, &how, NULL, &err);
    if (!gaussians) fail_msg("%s", err.text);
    assert_null(ffp_device());
    return gaussians;
}

static void assert_same_bits(const FfpGaussians *a, const FfpGaussians *b) {
    assert_int_equal(a->count, b->count);
    for (int k = 0; k < FFP_ATTRIBUTES; k++) {
        const FfpAttribute x = ffp_attribute(a, k), y = ffp_attribute(b, k);
        assert_memory_equal(x.data, y.data, (size_t)a->count * (size_t)x.width * sizeof(real));
    }
}

// How alike two reconstructions look: PSNR in dB of a view's pictures. Numbers cannot be held against each
// other one by one, since a splat that is refuted by a hair in one alone is missing there.
static double likeness(const FfpCapture *capture, const FfpGaussians *a, const FfpGaussians *b) {
    const FfpRenderSettings settings = ffp_render_defaults();
    const FfpView *view = &capture->views[1];
    FfpSummed white = ffp_summed_new(&capture->patterns[capture->white].image);
    FfpImage x = ffp_render_view(a, &view->camera, &view->projector, capture->intensity, &white, &settings),
             y = ffp_render_view(b, &view->camera, &view->projector, capture->intensity, &white, &settings);
    const double psnr = ffp_psnr(&x, &y);
    ffp_image_free(&x);
    ffp_image_free(&y);
    ffp_summed_free(&white);
    return psnr;
}

static void check(int64_t polish) {
    FfpError err = {0};
    FfpModelConfig config;
    assert_true(ffp_model_preset(&config, "tiny"));
    FfpModel *model = ffp_model_new(&config, 3, &err);
    FfpCapture capture = small_capture();
    FfpGaussians *here = reconstruct(&capture, model, polish, NULL),
                 *there = reconstruct(&capture, model, polish, device);
    const double psnr = likeness(&capture, here, there);
    print_message("%lld steps: %lld and %lld Gaussians, %.1f dB alike\n", (long long)polish,
                  (long long)here->count, (long long)there->count, psnr);
    if (llabs((long long)(here->count - there->count)) > here->count / 100 || psnr < 38) fail();
    ffp_gaussians_close(here);
    ffp_gaussians_close(there);
    capture.n_views = 4;
    ffp_capture_free(&capture);
    ffp_model_free(model);
}

// Whichever block of the device's memory cannot be had, the rooms' own scratch included: the call ends with
// an error, and the next one is as if nothing had been.
static void test_memory_ends(void **state) {
    (void)state;
    FfpError err = {0};
    FfpModelConfig config;
    assert_true(ffp_model_preset(&config, "tiny"));
    FfpModel *model = ffp_model_new(&config, 3, &err);
    FfpCapture capture = small_capture();
    const FfpReconstruction how = {
        .size = sizeof how, .model = model, .polish = 2, .layers = FFP_LAYERS_AUTO};
    FfpGaussians *gaussians = NULL;
    int failed = 0;
    for (long long blocks = 0; !gaussians; blocks += 1 + blocks / 4) {
        FfpContext context = {.device = device};
        ffp_cuda_memory_ends(blocks);
        gaussians = ffp_reconstruct(&context, &capture, &how, NULL, &err);
        assert_null(ffp_device());
        if (gaussians) break;
        assert_int_equal(err.code, FFP_ERROR_MEMORY);
        assert_non_null(strstr(err.text, "out of memory"));
        failed++;
    }
    print_message("%d failures\n", failed);
    assert_true(failed > 12);
    ffp_cuda_memory_ends(-1);
    FfpGaussians *again = reconstruct(&capture, model, 2, device);
    assert_same_bits(gaussians, again);
    ffp_gaussians_close(gaussians);
    ffp_gaussians_close(again);
    capture.n_views = 4;
    ffp_capture_free(&capture);
    ffp_model_free(model);
}

static void test_network(void **state) {
    (void)state;
    check(0);
}

static void test_polish(void **state) {
    (void)state;
    check(6);
}

// A capture with positions from Gray codes: a device does without them, and leaves them to the host.
static void test_codes(void **state) {
    (void)state;
    FfpCapture capture = small_capture();
    for (int v = 0; v < capture.n_views; v++) {
        FfpView *view = &capture.views[v];
        view->correspondence = ffp_image_new(view->camera.width, view->camera.height, 3);
        for (size_t i = 0; i < (size_t)view->camera.width * (size_t)view->camera.height; i++) {
            real *position = view->correspondence.data + 3 * i;
            position[0] = position[1] = 32;
            position[2] = i % 5 == 0 ? 0.5F : 0;
        }
    }
    FfpGaussians *here = reconstruct(&capture, NULL, 2, NULL),
                 *there = reconstruct(&capture, NULL, 2, device);
    assert_true(llabs((long long)(here->count - there->count)) <= here->count / 100);
    assert_true(likeness(&capture, here, there) >= 38);
    ffp_gaussians_close(here);
    ffp_gaussians_close(there);
    capture.n_views = 4;
    ffp_capture_free(&capture);
}

typedef struct Notes {
    int on_the_cpu;
    char last[200];
} Notes;

static void take_note(void *user, FfpLogLevel level, const char *text) {
    Notes *notes = user;
    (void)level;
    if (!strstr(text, "runs on the CPU")) return;
    notes->on_the_cpu++;
    snprintf(notes->last, sizeof notes->last, "%s", text);
}

// Fits on their own smooth or control density: they are the CPU's, and say so where a device is offered.
static void test_fits_on_their_own(void **state) {
    (void)state;
    FfpError err = {0};
    FfpCapture capture = small_capture();
    const FfpRefinement how = {.size = sizeof how, .steps = 3, .seed = 1};
    Notes notes = {0};
    FfpContext with = {.settings = {.user = &notes, .log = take_note}, .device = device};
    FfpContext without = {.settings = {.user = &notes, .log = take_note}};
    FfpGaussians *here = reconstruct(&capture, NULL, 0, NULL);
    FfpGaussians there = ffp_gaussians_copy(here);
    assert_true(ffp_refine_gaussians(&without, here, &capture, &how, NULL, &err));
    assert_int_equal(notes.on_the_cpu, 0);
    assert_true(ffp_refine_gaussians(&with, &there, &capture, &how, NULL, &err));
    assert_int_equal(notes.on_the_cpu, 1);
    assert_non_null(strstr(notes.last, "smoothing"));
    assert_same_bits(here, &there);
    ffp_gaussians_close(here);
    ffp_gaussians_free(&there);
    here = ffp_fit_from_scratch(&with, &capture, NULL, &how, NULL, &err);
    assert_non_null(here);
    assert_int_equal(notes.on_the_cpu, 2);
    assert_non_null(strstr(notes.last, "density"));
    ffp_gaussians_close(here);
    capture.n_views = 4;
    ffp_capture_free(&capture);
}

int main(void) {
    if (!(device = find_device())) return 0;
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_memory_ends), cmocka_unit_test(test_network),
                                       cmocka_unit_test(test_polish), cmocka_unit_test(test_codes),
                                       cmocka_unit_test(test_fits_on_their_own)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
