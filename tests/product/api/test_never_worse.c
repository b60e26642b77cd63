// A reconstruction is never worse on its photographs than the classical initialisation: weights that spoil it
// are left out, and looks serve the network alone.
#include <stdlib.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/rng.h"
#include "core/gaussians/gaussians.h"
#include "engine/network/network.h"
#include "ffprocams.h"
#include "product/cli/tiny.h"
#include "scratch.h"

static FfpGaussians *reconstruct(const FfpCapture *capture, const FfpModel *model, int64_t polish,
                                 FfpReconstructionStats *stats) {
    FfpError err = {0};
    const FfpReconstruction how = {.size = sizeof how, .model = model, .polish = polish};
    FfpGaussians *gaussians = ffp_reconstruct(NULL, capture, &how, stats, &err);
    if (!gaussians) fail_msg("%s", err.text);
    return gaussians;
}

// An untrained network gives the classical initialisation, because its heads' last layers are zero; here they
// are not.
static FfpModel *spoilt_model(void) {
    FfpModelConfig config;
    FfpError err = {0};
    assert_true(ffp_model_preset(&config, "tiny"));
    FfpModel *model = ffp_model_new(&config, 1, &err);
    FfpRng rng = ffp_rng(5, 1);
    for (int64_t i = 0; i < model->count; i++)
        if (model->values[i] == 0) model->values[i] = 0.3F * (real)ffp_rng_normal(&rng);
    return model;
}

static void assert_same(const FfpGaussians *a, const FfpGaussians *b) {
    assert_int_equal(a->count, b->count);
    assert_memory_equal(a->centre, b->centre, sizeof(real) * 3 * (size_t)a->count);
    assert_memory_equal(a->scale, b->scale, sizeof(real) * 3 * (size_t)a->count);
    assert_memory_equal(a->albedo, b->albedo, sizeof(real) * 3 * (size_t)a->count);
    assert_memory_equal(a->opacity, b->opacity, sizeof(real) * (size_t)a->count);
}

static void test_a_network_that_loses_is_dropped(void **state) {
    (void)state;
    FfpError err = {0};
    FfpCapture *capture = ffp_capture_open(NULL, scratch, NULL, &err);
    assert_non_null(capture);
    FfpModel *spoilt = spoilt_model();
    FfpReconstructionStats stats;
    FfpGaussians *start = reconstruct(capture, NULL, 0, &stats);
    assert_false(stats.network_dropped || stats.polish_dropped);
    FfpGaussians *kept = reconstruct(capture, spoilt, 0, &stats);
    assert_true(stats.network_dropped);
    assert_same(start, kept);

    FfpModelConfig config;
    assert_true(ffp_model_preset(&config, "tiny"));
    FfpModel *untrained = ffp_model_new(&config, 1, &err);
    FfpGaussians *same = reconstruct(capture, untrained, 0, &stats);
    assert_false(stats.network_dropped);
    assert_same(start, same);
    ffp_gaussians_close(start);
    ffp_gaussians_close(kept);
    ffp_gaussians_close(same);
    ffp_model_close(spoilt);
    ffp_model_close(untrained);
    ffp_capture_close(capture);
}

// A fit begins before the looks, so that they change nothing there.
static void test_a_fit_begins_before_looks(void **state) {
    (void)state;
    FfpError err = {0};
    FfpCapture *capture = ffp_capture_open(NULL, scratch, NULL, &err);
    assert_non_null(capture);
    FfpModelConfig config;
    assert_true(ffp_model_preset(&config, "tiny"));
    FfpModel *without = ffp_model_new(&config, 1, &err);
    config.looks = 2;
    FfpModel *with = ffp_model_new(&config, 2, &err);
    ffp_model_take_over(with, without);
    FfpRng rng = ffp_rng(7, 1);
    for (int64_t i = without->count; i < with->count; i++)
        if (with->values[i] == 0) with->values[i] = 1e-3F * (real)ffp_rng_normal(&rng);
    FfpReconstructionStats stats;
    for (int steps = 0; steps < 6; steps += 5) {
        FfpGaussians *a = reconstruct(capture, without, steps, &stats),
                     *b = reconstruct(capture, with, steps, &stats);
        assert_false(stats.network_dropped);
        if (steps)
            assert_same(a, b);
        else
            assert_true(a->count != b->count ||
                        memcmp(a->albedo, b->albedo, sizeof(real) * 3 * (size_t)a->count) != 0);
        ffp_gaussians_close(a);
        ffp_gaussians_close(b);
    }
    ffp_model_close(without);
    ffp_model_close(with);
    ffp_capture_close(capture);
}

// Whatever repeats is left out before anything looks at it.
static void test_views_given_twice_change_nothing(void **state) {
    (void)state;
    FfpError err = {0};
    FfpCapture *once = ffp_capture_open(NULL, scratch, NULL, &err);
    assert_non_null(once);
    FfpCapture twice = *once;
    const size_t n = (size_t)once->n_views;
    twice.n_views = 2 * once->n_views;
    twice.views = ffp_alloc(2 * n, sizeof *twice.views);
    for (size_t v = 0; v < 2 * n; v++) twice.views[v] = once->views[v % n];
    FfpReconstructionStats stats;
    FfpGaussians *a = reconstruct(once, NULL, 5, &stats), *b = reconstruct(&twice, NULL, 5, &stats);
    assert_same(a, b);
    ffp_gaussians_close(a);
    ffp_gaussians_close(b);
    ffp_free(twice.views);
    ffp_capture_close(once);
}

static int setup(void **state) {
    if (scratch_setup(state)) return 1;
    tiny_capture(scratch, 48);
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_network_that_loses_is_dropped),
        cmocka_unit_test(test_a_fit_begins_before_looks),
        cmocka_unit_test(test_views_given_twice_change_nothing),
    };
    return cmocka_run_group_tests(tests, setup, scratch_teardown);
}
