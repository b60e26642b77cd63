// The network as a whole: what an untrained one returns, that passes repeat their bits and take no new
// memory, what it refuses.
#include "core/base/alloc.h"
#include "engine/network/head.h"
#include "scene.h"

static void expect(const FfpError *err, const char *part) {
    if (strstr(err->text, part)) return;
    print_error("expected '%s' in '%s'\n", part, err->text);
    fail();
}

static FfpModel *new_model(const char *preset) {
    FfpModelConfig config;
    FfpError err;
    assert_true(ffp_model_preset(&config, preset));
    FfpModel *model = ffp_model_new(&config, 4, &err);
    assert_non_null(model);
    return model;
}

static void assert_near(const real *a, const real *b, int64_t count, real tolerance, const char *what) {
    for (int64_t i = 0; i < count; i++)
        if (!(fabs(a[i] - b[i]) <= tolerance)) {
            print_error("%s[%lld]: %g, expected %g\n", what, (long long)i, (double)a[i], (double)b[i]);
            fail();
        }
}

// One Gaussian of the classical initialisation by the formulas of docs/design/architecture.md, from the maps
// alone.
static void check_classical(const FfpGaussians *g, int64_t i, const FfpRun *run, const Scene *s) {
    const FfpInitialisation *start = &s->start;
    const int64_t p = run->pixel[i], area = (int64_t)start->width * start->height;
    const FfpCamera *camera = &s->capture.views[p / area].camera;
    real d[3], x, y;
    ffp_pixel_ray(camera, p % start->width + 0.5F, p % area / start->width + 0.5F, d);
    ffp_project(camera, g->centre + 3 * i, &x, &y);
    assert_true(fabs(x - (p % start->width + 0.5F)) < 1e-3F &&
                fabs(y - (p % area / start->width + 0.5F)) < 1e-3F);
    const real *q = g->rotation + 4 * i; // the third axis, column 2 of the rotation, is the normal
    const real axis[3] = {2 * (q[1] * q[3] + q[0] * q[2]), 2 * (q[2] * q[3] - q[0] * q[1]),
                          1 - 2 * (q[1] * q[1] + q[2] * q[2])};
    const real width = 0.425F * start->footprint[p], scale[3] = {width, width, 0.1F * width};
    const real opacity = fmax(0.924F * start->coverage[p], 1e-3F), roughness = 0.525F;
    assert_near(axis, start->normal + 3 * p, 3, 1e-4F, "axis");
    assert_near(g->scale + 3 * i, scale, 3, 1e-7F, "scale");
    assert_near(g->opacity + i, &opacity, 1, 1e-5F, "opacity");
    assert_near(g->roughness + i, &roughness, 1, 1e-6F, "roughness");
    assert_near(g->albedo + 3 * i, start->albedo + 3 * p, 3, 1e-5F, "albedo");
    assert_near(g->ambient + 3 * i, start->ambient + 3 * p, 3, 1e-5F, "ambient");
}

// Last layers start at zero: the classical initialisation comes out, Gaussian for Gaussian.
static void check_untrained(bool pixel_skip) {
    Scene s;
    scene_new(&s, 3, 24, 16, 9);
    FfpModel *model = new_model("tiny");
    FfpError err;
    if (!pixel_skip) {
        FfpModelConfig config = model->config;
        config.pixel_skip = false;
        ffp_model_free(model);
        assert_non_null(model = ffp_model_new(&config, 4, &err));
    }
    FfpRun *run = ffp_run_new(true);
    assert_true(ffp_model_forward(model, run, &s.capture, &s.start, NULL, SCENE_ACTIVE, &err));
    FfpGaussians start = ffp_initialisation_gaussians(&s.capture, &s.start);
    const FfpGaussians *g = &run->gaussians;
    assert_int_equal(g->count, start.count);
    assert_true(g->count > 100 && g->count < 3 * 24 * 16);
    for (int64_t i = 0; i < g->count; i++) {
        assert_true(s.start.coverage[run->pixel[i]] > 0);
        assert_true(run->t[i] == s.start.t[run->pixel[i]]);
        check_classical(g, i, run, &s);
    }
    assert_near(g->centre, start.centre, 3 * g->count, 1e-6F, "centre");
    assert_near(g->scale, start.scale, 3 * g->count, 1e-7F, "scale");
    assert_near(g->rotation, start.rotation, 4 * g->count, 1e-6F, "rotation");
    assert_near(g->opacity, start.opacity, g->count, 1e-6F, "opacity");
    assert_near(g->albedo, start.albedo, 3 * g->count, 1e-6F, "albedo");
    assert_near(g->roughness, start.roughness, g->count, 1e-6F, "roughness");
    assert_near(g->ambient, start.ambient, 3 * g->count, 1e-6F, "ambient");
    ffp_gaussians_free(&start);
    ffp_run_free(run);
    ffp_model_free(model);
    scene_free(&s);
}

static void test_untrained_pixel_skip(void **state) {
    (void)state;
    check_untrained(true);
}
static void test_untrained_token_head(void **state) {
    (void)state;
    check_untrained(false);
}

// The paper's form: every pixel, near the ray's nearest point, a footprint wide, opacity 0.12; no start
// needed.
static void test_plain_start(void **state) {
    (void)state;
    Scene s;
    scene_new(&s, 2, 16, 24, 2);
    FfpModel *model = new_model("paper-small");
    FfpRun *run = ffp_run_new(true);
    FfpError err;
    assert_true(ffp_model_forward(model, run, &s.capture, NULL, NULL, SCENE_ACTIVE, &err));
    const FfpGaussians *g = &run->gaussians;
    assert_int_equal(g->count, 2 * 16 * 24);
    for (int64_t i = 0; i < g->count; i++) {
        assert_int_equal(run->pixel[i], i);
        const FfpCamera *camera = &s.capture.views[i / (16 * 24)].camera;
        const real *c = g->centre + 3 * i, *q = g->rotation + 4 * i;
        real d[3];
        ffp_pixel_ray(camera, i % 16 + 0.5F, i / 16 % 24 + 0.5F, d);
        assert_true(fabs(ffp_dot3(c, d)) < 0.2F); // the nearest point is where the ray is square to it
        assert_true(fabs(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] - 1) < 1e-5F);
        assert_true(g->opacity[i] > 0.08F && g->opacity[i] < 0.17F);
        const real footprint = (run->t[i] - ffp_dot3(c, d)) / camera->fx;
        assert_true(g->scale[3 * i] > 0.8F * footprint && g->scale[3 * i] < 1.25F * footprint);
        assert_true(g->roughness[i] > 0.4F && g->roughness[i] < 0.65F);
    }
    ffp_run_free(run);
    ffp_model_free(model);
    scene_free(&s);
}

// The same capture again, after another one in between: the same bits, no more memory, every part of the
// profile filled.
static void test_repeats(void **state) {
    (void)state;
    Scene s, other;
    scene_new(&s, 3, 24, 16, 9);
    scene_new(&other, 3, 24, 16, 10);
    FfpModel *model = new_model("tiny");
    shake(model, 1);
    FfpRun *run = ffp_run_new(true);
    FfpProfile profile = {0};
    run->profile = &profile;
    real *grad[2], *centre[2];
    size_t memory[2];
    FfpError err;
    for (int i = 0; i < 2; i++) {
        grad[i] = ffp_alloc((size_t)model->count, sizeof(real));
        assert_true(ffp_model_forward(model, run, &s.capture, &s.start, NULL, SCENE_ACTIVE, &err));
        const size_t bytes = (size_t)run->gaussians.count * 3 * sizeof(real);
        centre[i] = ffp_alloc(bytes, 1);
        memcpy(centre[i], run->gaussians.centre, bytes);
        const FfpGaussians weights = run->gaussians;
        ffp_model_backward(model, run, &weights, run->t, grad[i]);
        if (i) assert_memory_equal(centre[0], centre[1], bytes);
        assert_true(ffp_model_forward(model, run, &other.capture, &other.start, NULL, SCENE_ACTIVE, &err));
        memory[i] = ffp_arena_high_water(run->arena);
    }
    assert_memory_equal(grad[0], grad[1], (size_t)model->count * sizeof(real));
    assert_int_equal(memory[0], memory[1]);
    const FfpProfileTimes *passes[] = {&profile.forward, &profile.backward};
    for (int i = 0; i < 2; i++) {
        assert_true(passes[i]->tokenise > 0 && passes[i]->scan > 0 && passes[i]->attention > 0);
        assert_true(passes[i]->products > 0 && passes[i]->other > 0 && passes[i]->heads > 0);
        ffp_free(grad[i]);
        ffp_free(centre[i]);
    }
    ffp_run_free(run);
    ffp_model_free(model);
    scene_free(&s);
    scene_free(&other);
}

// Blocks that share their memory, where no backward pass follows: the same bits in less of it.
static void test_forward_alone(void **state) {
    (void)state;
    Scene s;
    scene_new(&s, 3, 24, 16, 9);
    FfpModel *model = new_model("tiny");
    shake(model, 1);
    FfpRun *run[2] = {ffp_run_new(true), ffp_run_new(false)};
    FfpError err;
    for (int i = 0; i < 2; i++)
        assert_true(ffp_model_forward(model, run[i], &s.capture, &s.start, NULL, SCENE_ACTIVE, &err));
    for (int a = 0; a < FFP_ATTRIBUTES; a++) {
        const FfpAttribute x = ffp_attribute(&run[0]->gaussians, a), y = ffp_attribute(&run[1]->gaussians, a);
        if (!x.data && !y.data) continue; // scattered light: the network predicts none
        assert_memory_equal(x.data, y.data, (size_t)run[0]->gaussians.count * (size_t)x.width * sizeof(real));
    }
    assert_true(ffp_run_memory(run[1]) < ffp_run_memory(run[0]));
    ffp_run_free(run[0]), ffp_run_free(run[1]);
    ffp_model_free(model);
    scene_free(&s);
}

// No positional embedding and no fixed view count: one model takes any capture whose sides the patch divides.
static void test_other_sizes(void **state) {
    (void)state;
    FfpModel *model = new_model("tiny");
    FfpRun *run = ffp_run_new(true);
    const int sizes[][3] = {{1, 8, 8}, {5, 16, 8}, {2, 8, 48}, {1, 8, 8}};
    for (int i = 0; i < 4; i++) {
        Scene s;
        FfpError err;
        scene_new(&s, sizes[i][0], sizes[i][1], sizes[i][2], 1);
        assert_true(ffp_model_forward(model, run, &s.capture, &s.start, NULL, SCENE_ACTIVE, &err));
        real *grad = ffp_alloc((size_t)model->count, sizeof *grad);
        const FfpGaussians weights = run->gaussians;
        ffp_model_backward(model, run, &weights, NULL, grad);
        for (int64_t k = 0; k < model->count; k++) assert_true(isfinite(grad[k]));
        ffp_free(grad);
        memset(s.start.coverage, 0, sizeof(real) * (size_t)sizes[i][0] * sizes[i][1] * sizes[i][2]);
        assert_true(
            ffp_model_forward(model, run, &s.capture, &s.start, NULL, SCENE_ACTIVE, &err)); // nothing to see
        assert_int_equal(run->gaussians.count, 0);
        scene_free(&s);
    }
    ffp_run_free(run);
    ffp_model_free(model);
}

// Any sides and any number of pixels: tokens are made from a smaller capture, Gaussians for every pixel.
static void test_reduced(void **state) {
    (void)state;
    FfpModel *model = new_model("tiny");
    FfpRun *run = ffp_run_new(true);
    FfpError err;
    Scene s;
    scene_new(&s, 2, 44, 36, 1);
    int width, height;
    model->config.tokens = 12;
    ffp_pixel_context_size(&width, &height, &model->config, &s.capture, 2);
    assert_int_equal(width, 16);
    assert_int_equal(height, 16);
    const FfpGaussians start = ffp_initialisation_gaussians(&s.capture, &s.start);
    assert_true(ffp_model_forward(model, run, &s.capture, &s.start, NULL, SCENE_ACTIVE, &err));
    assert_int_equal(run->gaussians.count, start.count); // and the untrained network returns the start
    for (int64_t i = 0; i < 3 * start.count; i++)
        assert_float_equal(run->gaussians.centre[i], start.centre[i], 1e-5F);
    model->config.tokens = 1; // a token a view there is always
    ffp_pixel_context_size(&width, &height, &model->config, &s.capture, 2);
    assert_int_equal(width * height, 64);
    FfpGaussians copy = start;
    ffp_gaussians_free(&copy);
    scene_free(&s);
    ffp_run_free(run);
    ffp_model_free(model);
}

// A side of the contexts of `views` square views.
static int context_side(int side, int views) {
    FfpModelConfig config;
    assert_true(ffp_model_preset(&config, "small"));
    FfpView view = {.camera = {.width = side, .height = side}};
    const FfpCapture capture = {.n_views = views, .views = &view};
    int width, height;
    ffp_pixel_context_size(&width, &height, &config, &capture, views);
    assert_int_equal(width, height);
    return width;
}

static void test_many_views_keep_their_tokens(void **state) {
    (void)state;
    assert_int_equal(context_side(128, 8), 128);
    assert_int_equal(context_side(128, 64), 128);
    assert_int_equal(context_side(256, 4), 256);
    assert_int_equal(context_side(256, 8), 176); // of 181
    assert_int_equal(context_side(256, 32), 128);
}

// A ratio of footprints is told as far as training shows it.
static void test_the_ratio_told_is_limited(void **state) {
    (void)state;
    FfpModel *model = new_model("tiny");
    FfpError err;
    Scene s;
    FfpPixelContext context;
    const int64_t pixel = 0;
    real told[FFP_CONTEXT_CHANNELS];
    scene_new(&s, 2, 44, 36, 1);
    const int tokens[] = {40, 1}; // contexts of 32 x 32 and 8 x 8
    const real expected[] = {0.5F * log2((real)(44 * 36) / (32 * 32)), 0.68F};
    for (int i = 0; i < 2; i++) {
        model->config.tokens = tokens[i];
        assert_true(ffp_pixel_context_new(&context, &model->config, &s.capture, &s.start,
                                          &(int){SCENE_ACTIVE}, 1, &err));
        const FfpGrid grid = ffp_grid(&model->config, &s.capture, &context);
        ffp_head_context_inputs(told, &pixel, 1, &grid, &s.start, &context.start);
        assert_float_equal(told[0], expected[i], 1e-5F);
        ffp_pixel_context_free(&context);
    }
    scene_free(&s);
    ffp_model_free(model);
}

// The context, which tokens are made from, is matched with all patterns, too.
static void test_the_context_is_matched_with_all_patterns(void **state) {
    (void)state;
    FfpModel *model = new_model("tiny");
    FfpError err = {0};
    FfpCapture capture;
    if (!ffp_capture_read(&capture, FFP_SOURCE_DIR "/data/sample", &err)) fail_msg("%s", err.text);
    const real centre[3] = {capture.centre[0], capture.centre[1], capture.centre[2]};
    ffp_capture_normalise(&capture, centre, capture.radius);
    const int patterns[2] = {ffp_capture_find_pattern(&capture, "lollipop_0"),
                             ffp_capture_find_pattern(&capture, "lollipop_3")};
    const FfpInitialisation start = {.views = 2};
    FfpPixelContext one, two;
    model->config.tokens = 128; // two views of 64 x 64
    assert_true(ffp_pixel_context_new(&one, &model->config, &capture, &start, patterns, 1, &err));
    assert_true(ffp_pixel_context_new(&two, &model->config, &capture, &start, patterns, 2, &err));
    assert_true(one.reduced && two.reduced && two.start.width == 64 && two.start.views == 2);
    assert_null(one.capture.views[1].images[patterns[1]].data);
    assert_non_null(two.capture.views[1].images[patterns[1]].data);
    assert_memory_not_equal(one.start.t, two.start.t, 2 * 64 * 64 * sizeof(real));
    ffp_pixel_context_free(&one), ffp_pixel_context_free(&two);
    ffp_capture_free(&capture);
    ffp_model_free(model);
}

static void test_refusals(void **state) {
    (void)state;
    FfpModel *model = new_model("tiny");
    FfpRun *run = ffp_run_new(true);
    FfpError err;
    Scene s;
    scene_new(&s, 2, 4, 16, 1); // less than a patch
    assert_false(ffp_model_forward(model, run, &s.capture, &s.start, NULL, SCENE_ACTIVE, &err));
    expect(&err, "4 x 16");
    scene_free(&s);
    scene_new(&s, 2, 16, 16, 1);
    assert_false(ffp_model_forward(model, run, &s.capture, NULL, NULL, SCENE_ACTIVE, &err));
    expect(&err, "initialisation");
    assert_false(ffp_model_forward(model, run, &s.capture, &s.start, NULL, 3, &err));
    expect(&err, "pattern");
    FfpImage *image = &s.capture.views[1].images[SCENE_ACTIVE];
    const FfpImage whole = *image;
    image->data = NULL;
    assert_false(ffp_model_forward(model, run, &s.capture, &s.start, NULL, SCENE_ACTIVE, &err));
    expect(&err, "view_1");
    *image = whole;
    image->width = 8;
    assert_false(ffp_model_forward(model, run, &s.capture, &s.start, NULL, SCENE_ACTIVE, &err));
    expect(&err, "view_1");
    *image = whole;
    s.start.views = 3;
    assert_false(ffp_model_forward(model, run, &s.capture, &s.start, NULL, SCENE_ACTIVE, &err));
    expect(&err, "views");
    s.start.views = 2;
    s.start.height = 8;
    assert_false(ffp_model_forward(model, run, &s.capture, &s.start, NULL, SCENE_ACTIVE, &err));
    expect(&err, "size");
    s.start.height = 16;
    assert_true(ffp_model_forward(model, run, &s.capture, &s.start, NULL, SCENE_ACTIVE, &err));
    for (int64_t i = 0; i < model->count; i++) model->values[i] = 1e30F;
    assert_false(ffp_model_forward(model, run, &s.capture, &s.start, NULL, SCENE_ACTIVE, &err));
    expect(&err, "overflows");
    scene_free(&s);
    ffp_run_free(run);
    ffp_model_free(model);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_untrained_pixel_skip),
        cmocka_unit_test(test_untrained_token_head),
        cmocka_unit_test(test_plain_start),
        cmocka_unit_test(test_repeats),
        cmocka_unit_test(test_forward_alone),
        cmocka_unit_test(test_other_sizes),
        cmocka_unit_test(test_reduced),
        cmocka_unit_test(test_many_views_keep_their_tokens),
        cmocka_unit_test(test_the_ratio_told_is_limited),
        cmocka_unit_test(test_the_context_is_matched_with_all_patterns),
        cmocka_unit_test(test_refusals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
