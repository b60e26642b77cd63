// Gradients of the whole view pass, from Gaussians, pattern and intensity to pictures and G-buffers, against
// central differences.
#include "core/base/device.h"
#include "engine/render/gradients.h"
#include "engine/render/pass.h"
#include "engine/render/scenes.h"
#include "support.h"

enum { WIDTH = 17, HEIGHT = 11, PATTERN_WIDTH = 13, PATTERN_HEIGHT = 17 };

typedef struct PassCase {
    FfpViewPass *pass;
    FfpGaussians gaussians;
    FfpCamera camera, projector;
    real intensity[3];
    FfpImage pattern, weights[2], picture; // weights of the picture under black and under the pattern
    FfpGbuffer gbuffer_weights;
} PassCase;

static double picture_loss(PassCase *c, const FfpSummed *pattern, const FfpImage *weights) {
    double sum = 0;
    ffp_view_pass_shade(c->pass, c->intensity, pattern, &c->picture);
    for (int i = 0; i < 3 * WIDTH * HEIGHT; i++) sum += c->picture.data[i] * weights->data[i];
    return sum;
}

static double pass_loss(void *context) {
    PassCase *c = context;
    FfpSummed summed = ffp_summed_new(&c->pattern);
    ffp_view_pass_draw(c->pass, &c->gaussians, &c->camera, &c->projector);
    const double sum = picture_loss(c, NULL, &c->weights[0]) + picture_loss(c, &summed, &c->weights[1]) +
                       weighted(ffp_view_pass_gbuffer(c->pass), &c->gbuffer_weights);
    ffp_summed_free(&summed);
    return sum;
}

// Footprints and visibility are constants of the backward pass: here they do not change.
static PassCase pass_case(int samples) {
    static const real eye[3] = {2.1, -1.7, 1.1}, projector_eye[3] = {1.0, -1.6, 1.7}, origin[3] = {0};
    FfpRenderSettings settings = ffp_render_defaults();
    settings.samples = samples, settings.footprint = settings.shadows = false;
    PassCase c = {.pass = ffp_view_pass_new(&settings),
                  .gaussians = random_gaussians(20, 15, 0.5, 0.05, 0.3, 0.3, 0.95),
                  .camera = look_at(WIDTH, HEIGHT, 12, eye, origin),
                  .projector = look_at(PATTERN_WIDTH, PATTERN_HEIGHT, 14, projector_eye, origin),
                  .intensity = {2, 2.5, 3},
                  .pattern = ffp_image_new(PATTERN_WIDTH, PATTERN_HEIGHT, 3),
                  .weights = {ffp_image_new(WIDTH, HEIGHT, 3), ffp_image_new(WIDTH, HEIGHT, 3)},
                  .picture = ffp_image_new(WIDTH, HEIGHT, 3),
                  .gbuffer_weights = ffp_gbuffer_new(WIDTH, HEIGHT)};
    FfpRng rng = ffp_rng(9, 1);
    for (int i = 0; i < 3 * PATTERN_WIDTH * PATTERN_HEIGHT; i++) c.pattern.data[i] = between(&rng, 0, 1);
    for (int i = 0; i < 3 * WIDTH * HEIGHT; i++)
        for (int k = 0; k < 2; k++) c.weights[k].data[i] = between(&rng, -1, 1);
    randomise_gbuffer(&c.gbuffer_weights, 5);
    return c;
}

static void pass_case_free(PassCase *c) {
    ffp_view_pass_free(c->pass);
    ffp_gaussians_free(&c->gaussians);
    ffp_image_free(&c->pattern);
    for (int k = 0; k < 2; k++) ffp_image_free(&c->weights[k]);
    ffp_image_free(&c->picture);
    ffp_gbuffer_free(&c->gbuffer_weights);
}

typedef struct PassGradient {
    FfpGaussians gaussians;
    FfpImage pattern;
    real intensity[3];
} PassGradient;

static void add_gbuffer_gradient(PassCase *c) {
    Field to[FIELDS], from[FIELDS];
    gbuffer_fields(ffp_view_pass_grad_gbuffer(c->pass), to);
    gbuffer_fields(&c->gbuffer_weights, from);
    for (int k = 0; k < FIELDS; k++)
        for (int64_t i = 0; i < to[k].count; i++) to[k].data[i] += from[k].data[i];
}

// Twice, so that what an earlier draw left behind would show.
static PassGradient pass_gradient(PassCase *c) {
    PassGradient g = {.gaussians = ffp_gaussians_new(c->gaussians.count),
                      .pattern = ffp_image_new(PATTERN_WIDTH, PATTERN_HEIGHT, 3)};
    FfpSummed summed = ffp_summed_new(&c->pattern),
              grad_sum = ffp_summed_zeros(PATTERN_WIDTH, PATTERN_HEIGHT);
    FfpGaussians first = ffp_gaussians_new(c->gaussians.count);
    for (int i = 0; i < 2; i++) {
        ffp_view_pass_draw(c->pass, &c->gaussians, &c->camera, &c->projector);
        ffp_view_pass_shade(c->pass, c->intensity, NULL, &c->picture);
        ffp_view_pass_shade_backward(c->pass, c->intensity, NULL, &c->weights[0], NULL, NULL);
        ffp_view_pass_shade(c->pass, c->intensity, &summed, &c->picture);
        ffp_view_pass_shade_backward(c->pass, c->intensity, &summed, &c->weights[1], i ? g.intensity : NULL,
                                     i ? &grad_sum : NULL);
        add_gbuffer_gradient(c);
        ffp_view_pass_backward(c->pass, i ? &g.gaussians : &first);
    }
    ffp_lookup_gather_pattern(&grad_sum, &g.pattern);
    ffp_gaussians_free(&first);
    ffp_summed_free(&summed);
    ffp_summed_free(&grad_sum);
    return g;
}

// The part of the pattern that scattered light follows is a constant of the backward pass too, but moves with
// the outermost centres: these are not looked at where light is scattered.
static void check_pass(int samples, bool scatters) {
    char what[32];
    snprintf(what, sizeof what, "%d a side%s", samples, scatters ? ", scattered" : "");
    PassCase c = pass_case(samples);
    if (scatters) {
        scatter_light(&c.gaussians, 6);
        ffp_gbuffer_add_scattered(&c.gbuffer_weights);
        randomise_gbuffer(&c.gbuffer_weights, 5);
    }
    const double loss = pass_loss(&c);
    assert_true(isfinite(loss));
    PassGradient g = pass_gradient(&c);
    Field fields[FIELDS], analytic[FIELDS];
    gaussian_fields(&c.gaussians, fields);
    gaussian_fields(&g.gaussians, analytic);
    for (int k = scatters ? 1 : 0; k < (scatters ? FIELDS : FIELDS - 1); k++)
        check_field(what, &fields[k], analytic[k].data, pass_loss, &c);
    const Field intensity = {"intensity", c.intensity, 3};
    check_field(what, &intensity, g.intensity, pass_loss, &c);
    const Field pattern = {"pattern", c.pattern.data, 3 * PATTERN_WIDTH * PATTERN_HEIGHT};
    check_field(what, &pattern, g.pattern.data, pass_loss, &c);
    for (int k = 0; k < 3; k++) assert_true(fabs(g.intensity[k]) > 1e-4);
    ffp_gaussians_free(&g.gaussians);
    ffp_image_free(&g.pattern);
    pass_case_free(&c);
}

static void test_one_sample(void **state) {
    (void)state;
    check_pass(1, false);
}

static void test_two_samples(void **state) {
    (void)state;
    check_pass(2, false);
}

static void test_three_samples(void **state) {
    (void)state;
    check_pass(3, false);
}

static void test_four_samples(void **state) {
    (void)state;
    check_pass(4, false);
}

static void test_scattered(void **state) {
    (void)state;
    check_pass(1, true);
    check_pass(2, true);
}

// Scattered light follows the mean of the pattern, and nothing else: in a pattern's dark part it is what
// white shows there by it, times the mean.
static void test_scattered_follows_the_mean(void **state) {
    (void)state;
    PassCase c = pass_case(2);
    FfpImage dark = ffp_image_new(WIDTH, HEIGHT, 3), half = ffp_image_new(WIDTH, HEIGHT, 3);
    ffp_memory_zero(c.gaussians.albedo, (size_t)c.gaussians.count * 3 * sizeof(real));
    for (int i = 0; i < c.gaussians.count; i++) c.gaussians.roughness[i] = 1;
    scatter_light(&c.gaussians, 6);
    for (int i = 0; i < PATTERN_WIDTH * PATTERN_HEIGHT; i++)
        for (int k = 0; k < 3; k++) c.pattern.data[3 * i + k] = 0.4;
    c.intensity[0] = c.intensity[1] = c.intensity[2] = 0; // no direct light
    FfpSummed summed = ffp_summed_new(&c.pattern);
    ffp_view_pass_draw(c.pass, &c.gaussians, &c.camera, &c.projector);
    ffp_view_pass_radiance(c.pass, c.intensity, NULL, &dark);
    ffp_view_pass_radiance(c.pass, c.intensity, &summed, &half);
    const FfpGbuffer *g = ffp_view_pass_gbuffer(c.pass);
    double most = 0;
    for (int i = 0; i < 3 * WIDTH * HEIGHT; i++) {
        assert_true(fabs(half.data[i] - dark.data[i] - 0.4 * g->scattered[i]) < 1e-9);
        most = fmax(most, g->scattered[i]);
    }
    assert_true(most > 0.05);
    ffp_summed_free(&summed);
    ffp_image_free(&dark), ffp_image_free(&half);
    pass_case_free(&c);
}

typedef struct HoldCase {
    PassCase c;
    FfpSummed light;
    FfpImage positions;
} HoldCase;

static double hold_loss(void *context) {
    HoldCase *h = context;
    ffp_view_pass_draw(h->c.pass, &h->c.gaussians, &h->c.camera, &h->c.projector);
    ffp_view_pass_shade(h->c.pass, h->c.intensity, &h->light, &h->c.picture);
    return (double)ffp_view_pass_hold(h->c.pass, &h->positions, 2, 3);
}

// Places near and far, and unknown ones.
static void test_places_are_held(void **state) {
    (void)state;
    HoldCase h = {.c = pass_case(2), .positions = ffp_image_new(WIDTH, HEIGHT, 3)};
    FfpRng rng = ffp_rng(4, 1);
    h.light = ffp_summed_new(&h.c.pattern);
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        real *p = h.positions.data + 3 * i;
        p[0] = between(&rng, 0, PATTERN_WIDTH), p[1] = between(&rng, 0, PATTERN_HEIGHT), p[2] = i % 5 > 0;
    }
    FfpGaussians grad = ffp_gaussians_new(h.c.gaussians.count);
    assert_true(hold_loss(&h) > 0.1);
    ffp_view_pass_backward(h.c.pass, &grad);
    Field fields[FIELDS], analytic[FIELDS];
    gaussian_fields(&h.c.gaussians, fields);
    gaussian_fields(&grad, analytic);
    for (int k = 0; k < FIELDS - 1; k++) check_field("held", &fields[k], analytic[k].data, hold_loss, &h);
    double most = 0;
    for (int64_t i = 0; i < 3 * grad.count; i++) most = fmax(most, fabs((double)grad.centre[i]));
    assert_true(most > 1e-2);
    for (int i = 0; i < WIDTH * HEIGHT; i++) h.positions.data[3 * i + 2] = 0;
    assert_true(hold_loss(&h) == 0);
    ffp_gaussians_free(&grad);
    ffp_image_free(&h.positions);
    ffp_summed_free(&h.light);
    pass_case_free(&h.c);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_one_sample),
        cmocka_unit_test(test_two_samples),
        cmocka_unit_test(test_three_samples),
        cmocka_unit_test(test_places_are_held),
        cmocka_unit_test(test_four_samples),
        cmocka_unit_test(test_scattered),
        cmocka_unit_test(test_scattered_follows_the_mean),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
