// The memory that a reconstruction is said to need against what it takes.
// Labels: slow
#include <malloc.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/memory.h"
#include "core/capture/capture.h"
#include "engine/network/network.h"
#include "engine/pipeline/compensate.h"
#include "engine/pipeline/correspondence.h"
#include "engine/pipeline/need.h"
#include "engine/pipeline/pictures.h"
#include "engine/pipeline/reconstruct.h"
#include "scratch.h"
#include "support.h"

#define SAMPLE FFP_SOURCE_DIR "/data/sample"
#define LEAST 0.8
#define MOST 1.6

static void enlarge(FfpImage *image, int times) {
    if (!image->data) return;
    const FfpImage larger = ffp_image_resize(image, times * image->width, times * image->height);
    ffp_image_free(image);
    *image = larger;
}

// The sample, photographed more finely.
static FfpCapture *sample_times(int times) {
    FfpError err = {0};
    FfpCapture *capture = ffp_capture_load(SAMPLE, &err);
    if (!capture) fail_msg("%s", err.text);
    for (int v = 0; v < capture->n_views; v++) {
        FfpView *view = &capture->views[v];
        for (int p = 0; p < capture->n_patterns; p++) enlarge(&view->images[p], times);
        enlarge(&view->coverage, times), enlarge(&view->depth, times);
        view->camera.width *= times, view->camera.height *= times;
        view->camera.fx *= (real)times, view->camera.fy *= (real)times;
        view->camera.cx *= (real)times, view->camera.cy *= (real)times;
    }
    return capture;
}

static void close_capture(FfpCapture *capture) {
    ffp_capture_free(capture);
    ffp_free(capture);
}

static void compare(int times, const FfpModel *model, int64_t polish, int n_patterns) {
    static const char *const names[] = {"lollipop_0", "lollipop_1", "lollipop_2", "lollipop_3"};
    FfpError err = {0};
    FfpCapture *capture = sample_times(times);
    const FfpReconstruction how = {
        .model = model, .patterns = names, .n_patterns = n_patterns, .polish = polish, .noise = 0.002};
    const FfpProblemSize scale = ffp_problem_size(capture, &how);
    malloc_trim(0);
    const double before = ffp_memory_mark();
    FfpGaussians *gaussians = ffp_reconstruction_run(capture, &how, NULL, &err);
    if (!gaussians) fail_msg("%s", err.text);
    const double taken = ffp_memory_peak() - before, said = ffp_reconstruction_bytes(&scale);
    ffp_gaussians_free(gaussians);
    ffp_free(gaussians);
    close_capture(capture);
    if (before < 0) skip();
    print_message("%d x %d, %d patterns, %s, %d steps: %.0f MB said, %.0f MB taken\n", scale.width,
                  scale.height, n_patterns, model ? "network" : "start", (int)polish, said / 1e6,
                  taken / 1e6);
    if (said < LEAST * taken || said > MOST * taken)
        fail_msg("%.0f MB said, %.0f MB taken", said / 1e6, taken / 1e6);
}

// A sanitizer's own memory (shadow, freed blocks that it keeps) is many times the program's.
static void only_without_sanitizers(void) {
#ifdef FFP_SANITIZED
    skip();
#endif
}

static void test_start(void **state) {
    (void)state;
    only_without_sanitizers();
    compare(2, NULL, 0, 1);
    compare(4, NULL, 0, 1);
    compare(3, NULL, 0, 4);
}

static void test_network_and_polish(void **state) {
    (void)state;
    only_without_sanitizers();
    FfpError err = {0};
    FfpModelConfig config;
    assert_true(ffp_model_preset(&config, "tiny"));
    FfpModel *model = ffp_model_new(&config, 1, &err);
    compare(2, model, 0, 1);
    compare(2, NULL, 2, 1); // a pair of steps, which two threads take at once
    compare(3, model, 2, 1);
    compare(3, model, 2, 4);
    ffp_model_free(model);
}

// The first view, seen more finely.
static FfpView finer(const FfpCapture *capture, int times) {
    FfpView view = capture->views[0];
    FfpCamera *c = &view.camera;
    c->width *= times;
    c->height *= times;
    c->fx *= (real)times;
    c->fy *= (real)times;
    c->cx *= (real)times;
    c->cy *= (real)times;
    view.images = NULL;
    return view;
}

static void hold(const char *what, const FfpView *view, double before, double said) {
    const double taken = ffp_memory_peak() - before;
    print_message("%s of %d x %d: %.0f MB said, %.0f MB taken\n", what, view->camera.width,
                  view->camera.height, said / 1e6, taken / 1e6);
    if (before >= 0 && (said < LEAST * taken || said > MOST * taken))
        fail_msg("%.0f MB said, %.0f MB taken", said / 1e6, taken / 1e6);
}

static void map(const FfpCapture *capture, const FfpGaussians *gaussians, int times) {
    FfpError err = {0};
    const FfpView view = finer(capture, times);
    malloc_trim(0);
    const double before = ffp_memory_mark();
    FfpImages *images = ffp_warps_of_view(gaussians, capture, &view, (FfpDrawing){.samples = 2}, NULL, &err);
    if (!images) fail_msg("%s", err.text);
    ffp_images_free(images);
    hold("maps", &view, before, ffp_warps_bytes((double)gaussians->count, &view, 2));
}

static void compensate(FfpCapture *capture, const FfpGaussians *gaussians, int times) {
    static const unsigned char grey[3] = {90, 90, 90};
    const FfpRaw target = {.data = grey, .width = 1, .height = 1, .channels = 3, .row_bytes = 3};
    const FfpView usual = capture->views[0], view = finer(capture, times), *views = &view;
    const FfpCompensation options = {
        .n_targets = 1, .n_views = 1, .views = (const char *const[]){usual.id}, .paint = true, .steps = 1};
    FfpError err = {0};
    capture->views[0] = view;
    malloc_trim(0);
    const double before = ffp_memory_mark();
    FfpImages *images = ffp_compensation_run(gaussians, capture, &options, &target, NULL, &err);
    capture->views[0] = usual;
    if (!images) fail_msg("%s", err.text);
    ffp_images_free(images);
    hold("compensation", &view, before, ffp_compensation_bytes((double)gaussians->count, &views, 1, 2));
}

// Of strips so low that their margins count.
static void draw_pictures(FfpCapture *capture, const FfpGaussians *gaussians, int rows, int margin) {
    const FfpView usual = capture->views[0];
    FfpView view = finer(capture, 8);
    view.camera.cx = 20000, view.camera.cy *= 60 / (real)view.camera.height;
    view.camera.width = 40000, view.camera.height = 60;
    const FfpPictures options = {.folder = in_scratch("pictures"),
                                 .views = (const char *const[]){usual.id},
                                 .n_views = 1,
                                 .patterns = (const char *const[]){"all_white"},
                                 .n_patterns = 1};
    FfpError err = {0};
    capture->views[0] = view;
    malloc_trim(0);
    const double before = ffp_memory_mark();
    const int written = ffp_pictures_run(gaussians, capture, &options, &err);
    capture->views[0] = usual;
    if (written != 1) fail_msg("%s", err.text);
    hold("pictures", &view, before,
         ffp_pictures_bytes((double)gaussians->count, &view.camera, 2, rows, margin, 1));
}

// Of a single view, seen ever more finely: pictures of more than two million pixels are drawn in strips.
static void test_maps_compensation_and_pictures(void **state) {
    (void)state;
    only_without_sanitizers();
    FfpError err = {0};
    FfpCapture *capture = sample_times(1);
    FfpGaussians *gaussians = ffp_reconstruction_run(capture, &(FfpReconstruction){.noise = 0}, NULL, &err);
    if (!gaussians) fail_msg("%s", err.text);
    for (int times = 8; times <= 16; times += 4) map(capture, gaussians, times);
    for (int times = 8; times <= 16; times += 8) compensate(capture, gaussians, times);
    draw_pictures(capture, gaussians, 25, 8);
    ffp_gaussians_free(gaussians);
    ffp_free(gaussians);
    close_capture(capture);
}

static void test_what_does_not_fit_is_refused(void **state) {
    (void)state;
    FfpError err = {0};
    FfpCapture *capture = sample_times(2);
    const FfpReconstruction how = {.polish = 1};
    FfpProblemSize scale = ffp_problem_size(capture, &how);
    const double need = ffp_reconstruction_bytes(&scale);
    assert_true(ffp_check_memory(capture, &how, -1, &err));
    assert_true(ffp_check_memory(capture, &how, need, &err));
    assert_false(ffp_check_memory(capture, &how, 0.6 * need, &err));
    const char *advice = strstr(err.text, "a resolution of ");
    assert_non_null(advice);
    assert_int_equal(sscanf(advice, "a resolution of %d x %d would fit", &scale.width, &scale.height), 2);
    assert_in_range(scale.width, 96, 240);
    assert_true(ffp_reconstruction_bytes(&scale) <= 0.6 * need);
    assert_false(ffp_check_memory(capture, &how, 1e3, &err));
    assert_non_null(strstr(err.text, "fewer views"));
    close_capture(capture);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_start),
                                       cmocka_unit_test(test_network_and_polish),
                                       cmocka_unit_test(test_maps_compensation_and_pictures),
                                       cmocka_unit_test(test_what_does_not_fit_is_refused)};
    return cmocka_run_group_tests(tests, scratch_setup, scratch_teardown);
}
