// The whole network's gradient in double: analytic against central differences, for every parameter, in every
// form.
#include <math.h>
#include "core/base/alloc.h"
#include "scene.h"

// A random linear functional of everything that comes out.
typedef struct Functional {
    FfpGaussians weight;
    real *t;
} Functional;

static Functional functional_new(Scene *s, int64_t count) {
    FfpRng rng = ffp_rng(5, 5);
    return (Functional){.weight = {.count = count,
                                   .centre = random_map(s, &rng, 3 * count, -1, 1),
                                   .scale = random_map(s, &rng, 3 * count, -9, 9),
                                   .rotation = random_map(s, &rng, 4 * count, -1, 1),
                                   .opacity = random_map(s, &rng, count, -1, 1),
                                   .albedo = random_map(s, &rng, 3 * count, -1, 1),
                                   .roughness = random_map(s, &rng, count, -1, 1),
                                   .ambient = random_map(s, &rng, 3 * count, -1, 1)},
                        .t = random_map(s, &rng, count, -1, 1)};
}

static double dot(const real *a, const real *b, int64_t count) {
    double sum = 0;
    for (int64_t i = 0; i < count; i++) sum += a[i] * b[i];
    return sum;
}

static double evaluate(const FfpModel *model, FfpRun *run, const Scene *s, const Functional *f) {
    FfpError err;
    assert_true(ffp_model_forward(model, run, &s->capture, &s->start, &s->context, SCENE_ACTIVE, &err));
    const FfpGaussians *g = &run->gaussians, *w = &f->weight;
    const int64_t n = g->count;
    return dot(g->centre, w->centre, 3 * n) + dot(g->scale, w->scale, 3 * n) +
           dot(g->rotation, w->rotation, 4 * n) + dot(g->opacity, w->opacity, n) +
           dot(g->albedo, w->albedo, 3 * n) + dot(g->roughness, w->roughness, n) +
           dot(g->ambient, w->ambient, 3 * n) + dot(run->t, f->t, n);
}

// Along `direction` over one parameter.
static void check_direction(FfpModel *model, FfpRun *run, const Scene *s, const Functional *f,
                            const FfpParameter *p, const real *direction, const real *grad) {
    const double step = 1e-5;
    real *values = model->values + p->offset;
    real *kept = ffp_alloc((size_t)p->count * sizeof *kept, 1);
    memcpy(kept, values, (size_t)p->count * sizeof *kept);
    for (int64_t i = 0; i < p->count; i++) values[i] = kept[i] + (real)step * direction[i];
    const double above = evaluate(model, run, s, f);
    for (int64_t i = 0; i < p->count; i++) values[i] = kept[i] - (real)step * direction[i];
    const double below = evaluate(model, run, s, f);
    memcpy(values, kept, (size_t)p->count * sizeof *kept);
    ffp_free(kept);
    const double numeric = (above - below) / (2 * step),
                 analytic = dot(grad + p->offset, direction, p->count);
    if (!(fabs(numeric - analytic) <= 2e-6 * fmax(fabs(numeric), fabs(analytic)) + 2e-6)) {
        print_error("%s %s: numeric %.10g, analytic %.10g\n", model->config.modules, p->name, numeric,
                    analytic);
        fail();
    }
}

static void check_parameter(FfpModel *model, FfpRun *run, const Scene *s, const Functional *f,
                            const FfpParameter *p, FfpRng *rng, const real *grad) {
    real *direction = ffp_alloc((size_t)p->count, sizeof *direction);
    // All entries at once, at unit length so that the step is the same for large and small parameters:
    for (int64_t i = 0; i < p->count; i++) direction[i] = ffp_rng_normal(rng) / sqrt((double)p->count);
    check_direction(model, run, s, f, p, direction, grad);
    memset(direction, 0, (size_t)p->count * sizeof *direction); // and a single one
    direction[ffp_rng_below(rng, (uint32_t)p->count)] = 1;
    check_direction(model, run, s, f, p, direction, grad);
    ffp_free(direction);
}

// Fewer than 12 tokens make a context of fewer pixels.
static void check_tokens(const FfpModelConfig *given, int tokens) {
    FfpModelConfig config = *given;
    config.tokens = tokens;
    Scene s;
    scene_new(&s, 2, 12, 8, 3);
    FfpError err;
    FfpModel *model = ffp_model_new(&config, 11, &err);
    assert_non_null(model);
    shake(model, 1);
    FfpRun *run = ffp_run_new(true);
    assert_true(
        ffp_pixel_context_new(&s.context, &config, &s.capture, &s.start, &(int){SCENE_ACTIVE}, 1, &err));
    assert_int_equal(s.context.reduced, tokens < 12);
    assert_true(ffp_model_forward(model, run, &s.capture, &s.start, &s.context, SCENE_ACTIVE, &err));
    const Functional f = functional_new(&s, run->gaussians.count);
    real *grad = ffp_alloc((size_t)model->count, sizeof *grad),
         *twice = ffp_alloc((size_t)model->count, sizeof *twice);
    ffp_model_backward(model, run, &f.weight, f.t, grad);
    for (int i = 0; i < 2; i++) ffp_model_backward(model, run, &f.weight, f.t, twice); // gradients are added
    for (int64_t i = 0; i < model->count; i++)
        assert_true(fabs(twice[i] - 2 * grad[i]) <= 1e-9 * (1 + fabs(grad[i])));
    FfpRng rng = ffp_rng(7, 7);
    for (int i = 0; i < model->n_parameters; i++) {
        const FfpParameter *p = &model->parameters[i];
        // Looks take what the others' splats show as given.
        if (!config.looks || strncmp(p->name, "look.", 5) == 0)
            check_parameter(model, run, &s, &f, p, &rng, grad);
    }
    ffp_free(grad);
    ffp_free(twice);
    ffp_pixel_context_free(&s.context);
    ffp_run_free(run);
    ffp_model_free(model);
    scene_free(&s);
}

// With tokens from the capture itself (two views of 3 x 2 patches), and from one of 2 x 1 patches a view.
static void check_config(const FfpModelConfig *config) {
    check_tokens(config, 12);
    check_tokens(config, 6);
}

static FfpModelConfig small_config(const char *modules, int dim, bool residual, bool match_input,
                                   bool pixel_skip) {
    FfpModelConfig config = {.name = "test",
                             .dim = dim,
                             .patch = 4,
                             .state = 6,
                             .chunk = 5,
                             .residual = residual,
                             .match_input = match_input,
                             .pixel_skip = pixel_skip,
                             .pixel_features = 3,
                             .pixel_hidden = 7,
                             .context_inputs = match_input && pixel_skip,
                             .render = "ours",
                             .samples = 2};
    strcpy(config.modules, modules);
    return config;
}

static void check_model(const char *modules, int dim, bool residual, bool match_input, bool pixel_skip,
                        bool appearance_cnn) {
    FfpModelConfig config = small_config(modules, dim, residual, match_input, pixel_skip);
    config.appearance_cnn = appearance_cnn;
    check_config(&config);
}

static void test_look(void **state) {
    (void)state;
    for (int residual = 0; residual < 2; residual++) {
        FfpModelConfig config = small_config("M", 64, residual, residual, true);
        config.looks = 1;
        config.look_hidden = 9;
        check_config(&config);
    }
}

static void test_residual_hybrid(void **state) {
    (void)state;
    check_model("MT", 128, true, true, true, false);
}
static void test_residual_transformer(void **state) {
    (void)state;
    check_model("T", 64, true, true, false, false);
}
static void test_plain_mamba(void **state) {
    (void)state;
    check_model("M", 64, false, false, false, false);
}
static void test_plain_long(void **state) {
    (void)state;
    check_model("MMMT", 64, false, true, true, false);
}
static void test_residual_without_maps(void **state) {
    (void)state;
    check_model("TM", 64, true, false, true, false);
}

static void test_convolutional_appearance(void **state) {
    (void)state;
    check_model("M", 64, true, true, true, true);
    check_model("T", 64, false, false, false, true);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_residual_hybrid),
        cmocka_unit_test(test_residual_transformer),
        cmocka_unit_test(test_plain_mamba),
        cmocka_unit_test(test_plain_long),
        cmocka_unit_test(test_residual_without_maps),
        cmocka_unit_test(test_convolutional_appearance),
        cmocka_unit_test(test_look),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
