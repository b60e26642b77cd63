// Views of different sizes, and sizes that are not whole patches: padded, and no worse for it.
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/capture/capture.h"
#include "core/capture/pad.h"
#include "core/gaussians/gaussians.h"
#include "engine/match/match.h"
#include "engine/network/network.h"
#include "engine/refine/refine.h"
#include "ffprocams.h"
#include "support.h"
#include "world/synth/synth.h"

#define SAMPLE FFP_SOURCE_DIR "/data/sample"

static FfpCapture *open_sample(void) {
    FfpError err = {0};
    FfpCapture *capture = ffp_capture_open(NULL, SAMPLE, NULL, &err);
    if (!capture) fail_msg("%s", err.text);
    return capture;
}

// The part of the picture from (left, top) on, which may lie outside: there it is 0.
static void reframe_image(FfpImage *image, int left, int top, int width, int height) {
    if (!image->data) return;
    FfpImage out = ffp_image_new(width, height, image->channels);
    const int n = image->channels;
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            const int i = x + left, j = y + top;
            if (i >= 0 && j >= 0 && i < image->width && j < image->height)
                memcpy(out.data + ((size_t)y * width + x) * n,
                       image->data + ((size_t)j * image->width + i) * n, sizeof(real) * n);
        }
    ffp_image_free(image);
    *image = out;
}

// The same rays in another frame.
static void reframe(FfpCapture *capture, int v, int left, int top, int width, int height) {
    FfpView *view = &capture->views[v];
    view->camera.width = width, view->camera.height = height;
    view->camera.cx -= (real)left, view->camera.cy -= (real)top;
    for (int p = 0; p < capture->n_patterns; p++) reframe_image(&view->images[p], left, top, width, height);
    reframe_image(&view->coverage, left, top, width, height);
    ffp_image_free(&view->depth), ffp_image_free(&view->normal), ffp_image_free(&view->albedo);
    ffp_image_free(&view->roughness), ffp_image_free(&view->direct_white);
}

static FfpModel *untrained(void) {
    FfpModelConfig config;
    FfpError err = {0};
    assert_true(ffp_model_preset(&config, "tiny"));
    FfpModel *model = ffp_model_new(&config, 1, &err);
    assert_non_null(model);
    return model;
}

// Of the Gaussians made from `capture`, on the sample's own photographs.
static double psnr_of(const FfpCapture *capture, const FfpModel *model, int64_t polish) {
    FfpError err = {0};
    const FfpReconstruction how = {.size = sizeof how, .model = model, .polish = polish};
    FfpGaussians *gaussians = ffp_reconstruct(NULL, capture, &how, NULL, &err);
    if (!gaussians) fail_msg("%s", err.text);
    FfpCapture *sample = open_sample();
    const int photographs[3] = {sample->black, sample->white, ffp_capture_active_pattern(sample, NULL, &err)};
    FfpRenderSettings settings = ffp_render_defaults();
    const double psnr = ffp_photographs_psnr(gaussians, sample, photographs, 3, &settings);
    assert_true(gaussians->baked.within == 0); // to the object on its turntable, the projector moves
    ffp_gaussians_close(gaussians);
    ffp_capture_close(sample);
    return psnr;
}

static void test_views_of_different_sizes(void **state) {
    (void)state;
    static const int frames[3][4] = {{0, 0, 128, 128}, {4, -4, 120, 136}, {-16, 16, 160, 96}};
    FfpModel *model = untrained();
    FfpCapture *plain = open_sample(), *mixed = open_sample();
    for (int v = 0; v < mixed->n_views; v++) {
        const int *f = frames[v % 3];
        reframe(mixed, v, f[0], f[1], f[2], f[3]);
    }
    const double before = psnr_of(plain, model, 0), after = psnr_of(mixed, model, 0),
                 polished = psnr_of(mixed, model, 10);
    if (!(fabs(before - after) <= 0.3)) fail_msg("%.2f dB instead of %.2f", after, before);
    if (!(polished >= after)) fail_msg("the polish of mixed sizes: %.2f dB after %.2f", polished, after);
    ffp_capture_close(plain);
    ffp_capture_close(mixed);
    ffp_model_free(model);
}

static void test_background_around_changes_nothing(void **state) {
    (void)state;
    FfpError err = {0};
    FfpCapture *plain = open_sample(), *wide = open_sample();
    const FfpReconstruction how = {.size = sizeof how, .polish = 0};
    for (int v = 0; v < wide->n_views; v++) reframe(wide, v, 0, 0, 128 + 4 * v, 141 - v);
    FfpGaussians *a = ffp_reconstruct(NULL, plain, &how, NULL, &err),
                 *b = ffp_reconstruct(NULL, wide, &how, NULL, &err);
    if (!a || !b) fail_msg("%s", err.text);
    assert_int_equal(a->count, b->count);
    assert_memory_equal(a->centre, b->centre, sizeof(real) * 3 * (size_t)a->count);
    assert_memory_equal(a->albedo, b->albedo, sizeof(real) * 3 * (size_t)a->count);
    assert_memory_equal(a->opacity, b->opacity, sizeof(real) * (size_t)a->count);
    ffp_gaussians_close(a), ffp_gaussians_close(b);
    ffp_capture_close(plain), ffp_capture_close(wide);
}

// Frames that cut the object: what lies outside them stays unknown when it becomes padding.
static void test_padding_is_not_background(void **state) {
    (void)state;
    FfpError err = {0};
    const FfpMatchSettings settings = ffp_match_defaults();
    FfpCapture *capture = open_sample();
    const int active = ffp_capture_active_pattern(capture, NULL, &err);
    const int photographs[3] = {capture->black, capture->white, active};
    for (int v = 0; v < capture->n_views; v++) reframe(capture, v, 20, 30, 67, 59);
    const real centre[3] = {capture->centre[0], capture->centre[1], capture->centre[2]};
    ffp_capture_normalise(capture, centre, capture->radius);
    FfpCapture padded = ffp_padded_capture(capture, photographs, 3, 32);
    assert_int_equal(padded.views[0].camera.width, 96);
    assert_int_equal(padded.views[0].camera.height, 64);
    FfpInitialisation cut, wide;
    assert_true(ffp_initialisation_new(&cut, capture, &active, 1, &settings, &err));
    assert_true(ffp_initialisation_new(&wide, &padded, &active, 1, &settings, &err));
    for (int row = 0; row < cut.views * cut.height; row++) {
        const size_t from = (size_t)row * 67, to = ((size_t)(row / 59) * 64 + (size_t)(row % 59)) * 96;
        assert_memory_equal(cut.t + from, wide.t + to, 67 * sizeof(real));
        assert_memory_equal(cut.confidence + from, wide.confidence + to, 67 * sizeof(real));
        assert_memory_equal(cut.coverage + from, wide.coverage + to, 67 * sizeof(real));
        assert_memory_equal(cut.violation + from, wide.violation + to, 67 * sizeof(real));
        assert_memory_equal(cut.normal + 3 * from, wide.normal + 3 * to, 3 * 67 * sizeof(real));
        assert_memory_equal(cut.albedo + 3 * from, wide.albedo + 3 * to, 3 * 67 * sizeof(real));
    }
    ffp_initialisation_free(&cut), ffp_initialisation_free(&wide);
    ffp_padded_capture_free(&padded, capture);
    ffp_capture_close(capture);
}

static FfpCapture make_scene(void) {
    FfpError err = {0};
    FfpCapture capture;
    FfpSceneSpec spec = ffp_scene_defaults();
    spec.rig = FFP_SCENE_WALK;
    spec.resolution = 56, spec.pattern_side = 60;
    spec.views = 2, spec.targets = 0, spec.lollipops = 1;
    spec.samples = 1, spec.ambient_rays = 1;
    if (!ffp_scene_make(&capture, &spec, &err)) fail_msg("%s", err.text);
    return capture;
}

// A whole scene has no silhouettes, and the range of its depths must survive the padding. `other` is how
// much lower the second view is than the first.
static void try_scene(int width, int height, int other, const FfpModel *model) {
    FfpError err = {0};
    FfpCapture scene = make_scene();
    for (int v = 0; v < scene.n_views; v++) reframe(&scene, v, 2, 1, width, height - v * other);
    const FfpReconstruction how = {.size = sizeof how, .model = model, .polish = 4, .noise = 0};
    FfpReconstructionStats stats;
    FfpGaussians *gaussians = ffp_reconstruct(NULL, &scene, &how, &stats, &err);
    if (!gaussians) fail_msg("%d x %d: %s", width, height, err.text);
    if (!(stats.psnr > 20)) fail_msg("%d x %d: %.2f dB", width, height, stats.psnr);
    assert_true(ffp_shadows_are_baked(gaussians, scene.views[1].projector.pose)); // it stood still
    ffp_gaussians_close(gaussians);
    ffp_capture_free(&scene);
}

static void test_scenes_of_any_size(void **state) {
    (void)state;
    static const int sizes[12][2] = {{56, 55}, {55, 56}, {53, 41}, {49, 50}, {47, 33}, {45, 45},
                                     {43, 52}, {42, 38}, {41, 31}, {39, 54}, {36, 28}, {33, 33}};
    FfpModel *model = untrained();
    for (int i = 0; i < 12; i++) try_scene(sizes[i][0], sizes[i][1], i % 3, model);
    try_scene(48, 40, 8, NULL);
    ffp_model_free(model);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_views_of_different_sizes),
                                       cmocka_unit_test(test_background_around_changes_nothing),
                                       cmocka_unit_test(test_padding_is_not_background),
                                       cmocka_unit_test(test_scenes_of_any_size)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
