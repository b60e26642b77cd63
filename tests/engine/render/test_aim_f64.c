// Gradients of linear and encoded pictures and of G-buffers with respect to both devices' poses and focal
// lengths, and, with footprints and shadows, to everything else, against central differences.
#include "core/base/alloc.h"
#include "engine/render/gradients.h"
#include "engine/render/pass.h"
#include "engine/render/scenes.h"
#include "support.h"

enum { WIDTH = 17, HEIGHT = 11, PATTERN_WIDTH = 13, PATTERN_HEIGHT = 17, PIXELS = WIDTH * HEIGHT };

typedef struct AimCase {
    FfpViewPass *pass;
    FfpGaussians gaussians;
    FfpCamera camera, projector;
    real turns[12], intensity[3]; // xi of camera and projector: 0
    FfpImage pattern, weights, picture;
    FfpGbuffer gbuffer_weights;
    real *visibility, *extent; // held, as the backward pass holds them
    bool linear;
} AimCase;

// exp(xi) pose to second order in xi, as much as a central difference can see.
static FfpCamera moved(const FfpCamera *camera, const real xi[6]) {
    FfpCamera out = *camera;
    for (int column = 0; column < 4; column++) {
        real p[3], once[3], twice[3];
        for (int k = 0; k < 3; k++) p[k] = camera->pose[4 * k + column];
        ffp_cross3(xi + 3, p, once);
        if (column == 3)
            for (int k = 0; k < 3; k++) once[k] += xi[k];
        ffp_cross3(xi + 3, once, twice);
        for (int k = 0; k < 3; k++) out.pose[4 * k + column] = p[k] + once[k] + twice[k] / 2;
    }
    return out;
}

static void draw(AimCase *c) {
    const FfpCamera camera = moved(&c->camera, c->turns), projector = moved(&c->projector, c->turns + 6);
    ffp_view_pass_draw(c->pass, &c->gaussians, &camera, &projector);
    const FfpMapping *m = ffp_view_pass_mapping(c->pass);
    const size_t samples = (size_t)m->width * (size_t)m->height;
    const bool first = !c->visibility;
    if (first) {
        c->visibility = ffp_alloc(samples, sizeof(real));
        c->extent = ffp_alloc(samples, 2 * sizeof(real));
    }
    memcpy(first ? c->visibility : m->visibility, first ? m->visibility : c->visibility,
           samples * sizeof(real));
    memcpy(first ? c->extent : m->extent, first ? m->extent : c->extent, 2 * samples * sizeof(real));
}

static double aim_loss(void *context) {
    AimCase *c = context;
    FfpSummed summed = ffp_summed_new(&c->pattern);
    draw(c);
    ffp_view_pass_radiance(c->pass, c->intensity, &summed, &c->picture);
    if (!c->linear) ffp_view_pass_resolve(c->pass, &c->picture, &c->picture);
    double sum = weighted(ffp_view_pass_gbuffer(c->pass), &c->gbuffer_weights);
    for (int i = 0; i < 3 * PIXELS; i++) sum += c->picture.data[i] * c->weights.data[i];
    ffp_summed_free(&summed);
    return sum;
}

static AimCase aim_case(int samples, bool shadows, bool linear) {
    static const real eye[3] = {2.1, -1.7, 1.1}, projector_eye[3] = {1.0, -1.6, 1.7}, origin[3] = {0};
    FfpRenderSettings settings = ffp_render_defaults();
    settings.samples = samples, settings.footprint = settings.shadows = shadows;
    AimCase c = {.pass = ffp_view_pass_new(&settings),
                 .gaussians = random_gaussians(20, 15, 0.5, 0.05, 0.3, 0.3, 0.95),
                 .camera = look_at(WIDTH, HEIGHT, 12, eye, origin),
                 .projector = look_at(PATTERN_WIDTH, PATTERN_HEIGHT, 14, projector_eye, origin),
                 .intensity = {2, 2.5, 3},
                 .pattern = ffp_image_new(PATTERN_WIDTH, PATTERN_HEIGHT, 3),
                 .weights = ffp_image_new(WIDTH, HEIGHT, 3),
                 .picture = ffp_image_new(WIDTH, HEIGHT, 3),
                 .gbuffer_weights = ffp_gbuffer_new(WIDTH, HEIGHT),
                 .linear = linear};
    c.camera.fy *= 1.2, c.projector.fx *= 0.9;
    ffp_view_pass_expect_gradients(c.pass);
    FfpRng rng = ffp_rng(9, 1);
    for (int i = 0; i < 3 * PATTERN_WIDTH * PATTERN_HEIGHT; i++) c.pattern.data[i] = between(&rng, 0, 1);
    for (int i = 0; i < 3 * PIXELS; i++) c.weights.data[i] = between(&rng, -1, 1);
    randomise_gbuffer(&c.gbuffer_weights, 5);
    return c;
}

static void aim_case_free(AimCase *c) {
    ffp_view_pass_free(c->pass);
    ffp_gaussians_free(&c->gaussians);
    ffp_image_free(&c->pattern);
    ffp_image_free(&c->weights);
    ffp_image_free(&c->picture);
    ffp_gbuffer_free(&c->gbuffer_weights);
    ffp_free(c->visibility);
    ffp_free(c->extent);
}

typedef struct Gradient {
    FfpGaussians gaussians;
    FfpImage pattern;
    real intensity[3], turns[12], camera_focal[2], projector_focal[2];
} Gradient;

static void take_aim(const FfpAimGradient *aim, Gradient *g) {
    for (int k = 0; k < 6; k++) g->turns[k] = aim->camera[k], g->turns[6 + k] = aim->projector[k];
    for (int k = 0; k < 2; k++)
        g->camera_focal[k] = aim->camera_focal[k], g->projector_focal[k] = aim->projector_focal[k];
}

static void weigh_gbuffer(AimCase *c) {
    Field to[FIELDS], from[FIELDS];
    gbuffer_fields(ffp_view_pass_grad_gbuffer(c->pass), to);
    gbuffer_fields(&c->gbuffer_weights, from);
    for (int k = 0; k < FIELDS; k++)
        for (int64_t i = 0; i < to[k].count; i++) to[k].data[i] += from[k].data[i];
}

// Twice after one draw: what the first time left behind would show. Another pattern is looked at in between,
// so that what is kept of lookups is that one's.
static Gradient gradient_of(AimCase *c) {
    Gradient g = {.pattern = ffp_image_new(PATTERN_WIDTH, PATTERN_HEIGHT, 3)};
    FfpImage other = ffp_image_new(PATTERN_WIDTH, PATTERN_HEIGHT, 3), grad = ffp_image_new(WIDTH, HEIGHT, 3);
    other.data[7] = 1;
    FfpSummed summed = ffp_summed_new(&c->pattern), aside = ffp_summed_new(&other),
              scatter = ffp_summed_zeros(PATTERN_WIDTH, PATTERN_HEIGHT);
    draw(c);
    ffp_view_pass_radiance(c->pass, c->intensity, &summed, &c->picture);
    ffp_view_pass_radiance(c->pass, c->intensity, &aside, &grad);
    for (int i = 0; i < 2; i++) {
        FfpAimGradient aim = {.camera = {0}};
        ffp_gaussians_free(&g.gaussians);
        g.gaussians = ffp_gaussians_new(c->gaussians.count);
        ffp_view_pass_forget_gradients(c->pass);
        if (!c->linear) ffp_view_pass_resolve_backward(c->pass, &c->picture, &c->weights, &grad);
        ffp_view_pass_radiance_backward(c->pass, c->intensity, &summed, c->linear ? &c->weights : &grad,
                                        i ? g.intensity : NULL, i ? &scatter : NULL);
        weigh_gbuffer(c);
        ffp_view_pass_backward(c->pass, &g.gaussians);
        ffp_view_pass_backward_aim(c->pass, &g.gaussians, &aim);
        take_aim(&aim, &g);
    }
    ffp_lookup_gather_pattern(&scatter, &g.pattern);
    ffp_image_free(&other), ffp_image_free(&grad);
    ffp_summed_free(&summed), ffp_summed_free(&aside), ffp_summed_free(&scatter);
    return g;
}

static void check_devices(const char *what, AimCase *c, const Gradient *g) {
    const Field fields[] = {{"camera and projector pose", c->turns, 12},
                            {"camera fx", &c->camera.fx, 1},
                            {"camera fy", &c->camera.fy, 1},
                            {"projector fx", &c->projector.fx, 1},
                            {"projector fy", &c->projector.fy, 1}};
    const real *analytic[] = {g->turns, g->camera_focal, g->camera_focal + 1, g->projector_focal,
                              g->projector_focal + 1};
    for (int k = 0; k < 5; k++) {
        check_field(what, &fields[k], analytic[k], aim_loss, c);
        for (int64_t i = 0; i < fields[k].count; i++) assert_true(fabs(analytic[k][i]) > 1e-5);
    }
}

static void check(int samples, bool shadows, bool linear) {
    char what[64];
    snprintf(what, sizeof what, "%d a side, shadows %d, linear %d", samples, shadows, linear);
    AimCase c = aim_case(samples, shadows, linear);
    Gradient g = gradient_of(&c);
    check_devices(what, &c, &g);
    Field fields[FIELDS], analytic[FIELDS];
    gaussian_fields(&c.gaussians, fields);
    gaussian_fields(&g.gaussians, analytic);
    for (int k = 0; k < FIELDS; k++) check_field(what, &fields[k], analytic[k].data, aim_loss, &c);
    const Field intensity = {"intensity", c.intensity, 3},
                pattern = {"pattern", c.pattern.data, 3 * PATTERN_WIDTH * PATTERN_HEIGHT};
    check_field(what, &intensity, g.intensity, aim_loss, &c);
    check_field(what, &pattern, g.pattern.data, aim_loss, &c);
    int partly = 0;
    for (int i = 0; i < samples * samples * PIXELS; i++) partly += c.visibility[i] > 0 && c.visibility[i] < 1;
    assert_true(shadows == (partly > 0)); // shadows that are seen
    ffp_gaussians_free(&g.gaussians);
    ffp_image_free(&g.pattern);
    aim_case_free(&c);
}

static void test_encoded(void **state) {
    (void)state;
    for (int samples = 1; samples <= 2; samples++)
        for (int shadows = 0; shadows < 2; shadows++) check(samples, shadows, false);
}

static void test_linear(void **state) {
    (void)state;
    for (int shadows = 0; shadows < 2; shadows++) check(2, shadows, true);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_encoded), cmocka_unit_test(test_linear)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
