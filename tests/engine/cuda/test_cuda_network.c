// The whole network on a device against the CPU: the same Gaussians and gradients, up to the rounding of
// operands to bf16.
#include "compare.h"
#include "engine/network/scene.h"

static const FfpDevice *device;

typedef struct Case {
    const char *preset;
    int views, width, height, tokens, looks;
} Case;

// `slack` times what the rounding of operands costs: a look amplifies it.
static void check_gaussians(const FfpGaussians *there, const FfpGaussians *here, double slack) {
    assert_int_equal(there->count, here->count);
    const int64_t n = here->count;
    assert_close(there->centre, here->centre, 3 * n, slack * 2e-3, "centre");
    assert_close(there->scale, here->scale, 3 * n, slack * 2e-2, "scale");
    assert_close(there->rotation, here->rotation, 4 * n, slack * 2e-2, "rotation");
    assert_close(there->opacity, here->opacity, n, slack * 2e-2, "opacity");
    assert_close(there->albedo, here->albedo, 3 * n, slack * 2e-2, "albedo");
    assert_close(there->roughness, here->roughness, n, slack * 2e-2, "roughness");
    assert_close(there->ambient, here->ambient, 3 * n, slack * 2e-2, "ambient");
}

static FfpGaussians random_gradient(const FfpArena *arena, int64_t count, FfpRng *rng) {
    (void)arena;
    FfpGaussians g = ffp_gaussians_new(count);
    real *const arrays[] = {g.centre, g.scale, g.rotation, g.opacity, g.albedo, g.roughness, g.ambient};
    const int widths[] = {3, 3, 4, 1, 3, 1, 3};
    for (int a = 0; a < 7; a++)
        for (int64_t i = 0; i < widths[a] * count; i++) arrays[a][i] = (real)ffp_rng_normal(rng);
    return g;
}

static FfpGaussians uploaded(const FfpGaussians *g) {
    const size_t n = (size_t)g->count;
    return (FfpGaussians){.count = g->count,
                          .centre = ffp_memory_uploaded(g->centre, 3 * n, sizeof(real)),
                          .scale = ffp_memory_uploaded(g->scale, 3 * n, sizeof(real)),
                          .rotation = ffp_memory_uploaded(g->rotation, 4 * n, sizeof(real)),
                          .opacity = ffp_memory_uploaded(g->opacity, n, sizeof(real)),
                          .albedo = ffp_memory_uploaded(g->albedo, 3 * n, sizeof(real)),
                          .roughness = ffp_memory_uploaded(g->roughness, n, sizeof(real)),
                          .ambient = ffp_memory_uploaded(g->ambient, 3 * n, sizeof(real))};
}

static void release(FfpGaussians *g) {
    void *const arrays[] = {g->centre, g->scale,     g->rotation, g->opacity,
                            g->albedo, g->roughness, g->ambient};
    for (int a = 0; a < 7; a++) ffp_memory_free(arrays[a]);
}

// Forward and backward twice on the device (the same bits), once on the CPU.
static void check(const Case *c) {
    FfpModelConfig config;
    FfpError err = {0};
    assert_true(ffp_model_preset(&config, c->preset));
    config.tokens = c->tokens;
    config.looks = c->looks;
    FfpModel *model = ffp_model_new(&config, 4, &err);
    shake(model, 1);
    Scene s;
    scene_new(&s, c->views, c->width, c->height, 1);
    FfpRun *run = ffp_run_new(true);
    FfpRng rng = ffp_rng(5, 5);
    if (!ffp_model_forward(model, run, &s.capture, &s.start, NULL, SCENE_ACTIVE, &err))
        fail_msg("%s", err.text);
    const int64_t n = run->gaussians.count;
    print_message("%s, %d views of %d x %d: %lld Gaussians\n", c->preset, c->views, c->width, c->height,
                  (long long)n);
    FfpGaussians grad = random_gradient(s.arena, n, &rng);
    real *grad_t = random_map(&s, &rng, n, -1, 1), *values = random_map(&s, &rng, model->count, 0, 0);
    ffp_model_backward(model, run, &grad, grad_t, values);

    ffp_device_use(device);
    FfpRun *there = ffp_run_new(true);
    FfpModel model_there = ffp_model_uploaded(model);
    const double slack = 1 << c->looks;
    FfpGaussians grad_there = uploaded(&grad);
    real *grad_t_there = ffp_memory_uploaded(grad_t, (size_t)n, sizeof *grad_t), *first = NULL;
    for (int i = 0; i < 2; i++) {
        real *values_there = ffp_memory_new((size_t)model->count, sizeof(real));
        if (!ffp_model_forward(&model_there, there, &s.capture, &s.start, NULL, SCENE_ACTIVE, &err))
            fail_msg("%s", err.text);
        check_gaussians(&there->gaussians, &run->gaussians, slack);
        assert_close(there->t, run->t, n, slack * 2e-3, "t");
        ffp_model_backward(&model_there, there, &grad_there, grad_t_there, values_there);
        assert_close(values_there, values, model->count, slack * 5e-2, "gradient of the weights");
        real *copy = random_map(&s, &rng, model->count, 0, 0);
        ffp_memory_download(copy, values_there, (size_t)model->count * sizeof *copy);
        if (first) assert_memory_equal(first, copy, (size_t)model->count * sizeof *copy);
        first = copy;
        ffp_memory_free(values_there);
    }
    ffp_memory_free(grad_t_there);
    release(&grad_there);
    ffp_memory_free(model_there.values);
    ffp_run_free(there);
    ffp_device_use(NULL);
    ffp_gaussians_free(&grad);
    ffp_run_free(run);
    scene_free(&s);
    ffp_model_free(model);
}

static void test_residual(void **state) {
    (void)state;
    check(&(Case){"tiny", 2, 24, 16, 4096, 0});
}

static void test_reduced_context(void **state) {
    (void)state;
    check(&(Case){"tiny", 2, 44, 36, 12, 0});
}

static void test_looks(void **state) {
    (void)state;
    check(&(Case){"tiny", 3, 24, 16, 4096, 2});
    check(&(Case){"tiny", 2, 44, 36, 12, 1});
}

int main(void) {
    if (!(device = find_device())) return 0;
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_residual),
                                       cmocka_unit_test(test_reduced_context), cmocka_unit_test(test_looks)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
