// Gradients of the renderer against central differences, in double.
#include "engine/render/gradients.h"
#include "engine/render/scenes.h"
#include "support.h"

typedef struct RasterCase {
    FfpRaster *raster;
    FfpGaussians gaussians;
    FfpCamera camera;
    FfpRenderSettings settings;
    FfpGbuffer out, weights;
} RasterCase;

static double raster_loss(void *context) {
    RasterCase *c = context;
    ffp_rasterise(c->raster, &c->gaussians, &c->camera, &c->settings, &c->out);
    return weighted(&c->out, &c->weights);
}

static void check_rasterise(const char *what, FfpGaussians gaussians, FfpCamera camera,
                            FfpRenderSettings settings) {
    RasterCase c = {ffp_raster_new(),
                    gaussians,
                    camera,
                    settings,
                    ffp_gbuffer_new(camera.width, camera.height),
                    ffp_gbuffer_new(camera.width, camera.height)};
    FfpGaussians grad = ffp_gaussians_new(gaussians.count);
    randomise_gbuffer(&c.weights, 5);
    raster_loss(&c);
    double seen = 0;
    for (int p = 0; p < camera.width * camera.height; p++) seen += c.out.opacity[p];
    assert_true(seen > 10);
    ffp_rasterise_backward(c.raster, &c.gaussians, &c.camera, &c.settings, &c.out, &c.weights, &grad);
    Field fields[FIELDS], analytic[FIELDS];
    gaussian_fields(&c.gaussians, fields);
    gaussian_fields(&grad, analytic);
    for (int k = 0; k < FIELDS; k++) check_field(what, &fields[k], analytic[k].data, raster_loss, &c);
    ffp_gaussians_free(&grad);
    ffp_gaussians_free(&gaussians);
    ffp_gbuffer_free(&c.out);
    ffp_gbuffer_free(&c.weights);
    ffp_raster_free(c.raster);
}

static const real eye[3] = {2.1, -1.7, 1.1}, origin[3] = {0, 0, 0};

static void test_rasterise_gradients(void **state) {
    (void)state;
    FfpRenderSettings compensated = ffp_render_defaults();
    compensated.blur = 0.1, compensated.compensation = true, compensated.firmness = 0;
    check_rasterise("compensated", random_gaussians(24, 1, 0.7, 0.02, 0.2, 0.1, 0.9),
                    look_at(37, 23, 40, eye, origin), compensated);
    check_rasterise("firm", random_gaussians(24, 1, 0.7, 0.02, 0.2, 0.1, 0.9),
                    look_at(37, 23, 40, eye, origin), ffp_render_defaults());
    check_rasterise("paper", random_gaussians(24, 2, 0.7, 0.02, 0.2, 0.1, 0.9),
                    look_at(19, 35, 40, eye, origin), ffp_render_paper());
}

static void test_flat_and_opaque_gradients(void **state) {
    (void)state;
    FfpGaussians flat =
        random_gaussians(30, 3, 0.5, 0.05, 0.12, 0.95, 0.999); // alpha is cut at 0.99 here and there
    for (int64_t i = 0; i < flat.count; i++) flat.scale[3 * i + i % 3] *= 0.1;
    check_rasterise("flat", flat, look_at(33, 17, 35, eye, origin), ffp_render_defaults());
    // One behind the other, so that the transmittance ends
    check_rasterise("stacked", random_gaussians(40, 5, 0.15, 0.1, 0.2, 0.7, 0.95),
                    look_at(17, 33, 40, eye, origin), ffp_render_defaults());
}

static void test_off_centre_gradients(void **state) {
    (void)state;
    FfpCamera camera = look_at(31, 29, 40, eye, origin);
    camera.cx = -6.3, camera.cy = 36.7, camera.fy = 43; // outside the image
    FfpGaussians g = random_gaussians(24, 6, 0.6, 0.05, 0.3, 0.2, 0.9);
    for (int64_t i = 0; i < g.count; i++) {
        real *p = g.centre + 3 * i;
        for (int k = 0; k < 3; k++)
            p[k] += 0.7 * camera.pose[4 * k] - 0.6 * camera.pose[4 * k + 1]; // to where this camera looks
    }
    check_rasterise("off-centre", g, camera, ffp_render_defaults());
}

// A wide splat whose centre lies outside the margin around the image: the Jacobian's x/z is held there.
static void test_held_jacobian_gradients(void **state) {
    (void)state;
    FfpGaussians g = random_gaussians(8, 7, 0.4, 0.5, 0.9, 0.5, 0.9);
    FfpCamera camera = look_at(21, 15, 30, eye, origin);
    for (int64_t i = 0; i < g.count; i++)
        for (int k = 0; k < 3; k++)
            g.centre[3 * i + k] +=
                (i % 2 ? 1.4 : -1.4) * camera.pose[4 * k] + (i % 4 < 2 ? 1.1 : 0) * camera.pose[4 * k + 1];
    check_rasterise("held", g, camera, ffp_render_defaults());
}

typedef struct ShadeCase {
    FfpGbuffer gbuffer;
    FfpMapping mapping;
    FfpCamera camera, projector;
    real intensity[3];
    FfpImage pattern, out, weights;
} ShadeCase;

static double shade_loss(void *context) {
    ShadeCase *c = context;
    FfpSummed summed = ffp_summed_new(&c->pattern);
    ffp_shade_once(&c->gbuffer, &c->mapping, &c->camera, &c->projector, c->intensity, &summed, &c->out);
    ffp_summed_free(&summed);
    double sum = 0;
    for (int i = 0; i < 3 * c->out.width * c->out.height; i++) sum += c->out.data[i] * c->weights.data[i];
    return sum;
}

static ShadeCase shade_case(int width, int height) {
    const real projector_eye[3] = {1.0, -1.6, 1.7};
    ShadeCase c = {ffp_gbuffer_new(width, height),
                   ffp_mapping_new(width, height),
                   look_at(width, height, 12, eye, origin),
                   look_at(13, 17, 14, projector_eye, origin),
                   {5, 6, 7},
                   ffp_image_new(13, 17, 3),
                   ffp_image_new(width, height, 3),
                   ffp_image_new(width, height, 3)};
    FfpRng rng = ffp_rng(9, 1);
    c.projector.cx = 5.2, c.projector.cy = 9.1;
    for (int p = 0; p < width * height; p++) {
        const real o = c.gbuffer.opacity[p] = between(&rng, 0.3, 1);
        c.gbuffer.depth[p] = o * between(&rng, 2.6, 3.1);
        c.gbuffer.roughness[p] = o * between(&rng, 0.15, 0.95);
        for (int k = 0; k < 3; k++) {
            // facing the camera, more or less; sometimes away from the projector
            c.gbuffer.normal[3 * p + k] = -o * c.camera.pose[4 * k + 2] * 0.7 + o * between(&rng, -0.6, 0.6);
            c.gbuffer.albedo[3 * p + k] = o * between(&rng, 0.1, 0.9);
            c.gbuffer.ambient[3 * p + k] = o * between(&rng, 0, 0.4);
            c.weights.data[3 * p + k] = between(&rng, -1, 1);
        }
        for (int k = 0; k < 2; k++) c.mapping.extent[2 * p + k] = between(&rng, 1, 4);
        c.mapping.visibility[p] = p % 7 == 3 ? 0 : between(&rng, 0.2, 1);
    }
    for (int i = 0; i < 13 * 17 * 3; i++) c.pattern.data[i] = between(&rng, 0, 1);
    return c;
}

static void free_shade_case(ShadeCase *c) {
    ffp_gbuffer_free(&c->gbuffer);
    ffp_mapping_free(&c->mapping);
    ffp_image_free(&c->pattern);
    ffp_image_free(&c->out);
    ffp_image_free(&c->weights);
}

// The whole way back, from a picture's gradient to the G-buffer's.
static void shade_backward(ShadeCase *c, const FfpSummed *pattern, FfpGbuffer *grad, real grad_intensity[3],
                           FfpSummed *grad_pattern) {
    const int width = c->gbuffer.width, height = c->gbuffer.height;
    FfpTransport transport = ffp_transport_new(width, height), d = ffp_transport_new(width, height);
    ffp_light(&c->gbuffer, &c->mapping, &c->camera, &c->projector, &transport);
    ffp_shade_backward(&c->mapping, &transport, c->intensity, pattern, &c->weights, grad, &d, grad_intensity,
                       grad_pattern);
    ffp_light_backward(&c->gbuffer, &c->mapping, &c->camera, &c->projector, &d, grad);
    ffp_transport_free(&transport);
    ffp_transport_free(&d);
}

static void check_shade(const char *what, ShadeCase *c) {
    FfpGbuffer grad = ffp_gbuffer_new(c->gbuffer.width, c->gbuffer.height);
    FfpSummed summed = ffp_summed_new(&c->pattern), grad_sum = ffp_summed_zeros(13, 17);
    FfpImage grad_pattern = ffp_image_new(c->pattern.width, c->pattern.height, 3);
    real grad_intensity[3] = {0};
    shade_backward(c, &summed, &grad, grad_intensity, &grad_sum);
    ffp_lookup_gather_pattern(&grad_sum, &grad_pattern);
    Field fields[FIELDS], analytic[FIELDS];
    gbuffer_fields(&c->gbuffer, fields);
    gbuffer_fields(&grad, analytic);
    for (int k = 0; k < 6; k++) check_field(what, &fields[k], analytic[k].data, shade_loss, c);
    const Field intensity = {"intensity", c->intensity, 3};
    check_field(what, &intensity, grad_intensity, shade_loss, c);
    const Field pattern = {"pattern", c->pattern.data, 3 * 13 * 17};
    check_field(what, &pattern, grad_pattern.data, shade_loss, c);
    for (int k = 0; k < 3; k++) assert_true(fabs(grad_intensity[k]) > 1e-4);
    ffp_summed_free(&summed);
    ffp_summed_free(&grad_sum);
    ffp_image_free(&grad_pattern);
    ffp_gbuffer_free(&grad);
}

static void test_shade_gradients(void **state) {
    (void)state;
    ShadeCase c = shade_case(11, 9);
    double direct = 0;
    shade_loss(&c);
    for (int i = 0; i < 3 * 11 * 9; i++) direct += c.out.data[i] - c.gbuffer.ambient[i];
    assert_true(direct > 1);
    check_shade("shade", &c);
    free_shade_case(&c);
}

// Without cosine and falloff, n.l held where the surface looks away.
static void test_even_light_gradients(void **state) {
    (void)state;
    ShadeCase c = shade_case(11, 9);
    const double usual = shade_loss(&c);
    c.mapping.even = 1.7;
    assert_true(fabs(shade_loss(&c) - usual) > 1e-3);
    check_shade("even light", &c);
    free_shade_case(&c);
}

// Pixels at the edges of the model: nearly no opacity, a cancelled normal, roughness 0, a normal turned away.
static void test_shade_edge_gradients(void **state) {
    (void)state;
    ShadeCase c = shade_case(7, 5);
    for (int p = 0; p < 35; p++) {
        if (p % 5 == 0) c.gbuffer.roughness[p] = 0;
        if (p % 5 == 1) c.gbuffer.opacity[p] = p % 2 ? 0 : 5e-4;
        for (int k = 0; k < 3; k++) {
            if (p % 5 == 2) c.gbuffer.normal[3 * p + k] *= 0.02;
            if (p % 5 == 3) c.gbuffer.normal[3 * p + k] *= -1;
        }
    }
    check_shade("edges", &c);
    free_shade_case(&c);
}

// Under black only the ambient colour is seen, and only it has a gradient.
static void test_shade_black(void **state) {
    (void)state;
    ShadeCase c = shade_case(5, 3);
    FfpGbuffer grad = ffp_gbuffer_new(5, 3);
    ffp_shade_once(&c.gbuffer, &c.mapping, &c.camera, &c.projector, c.intensity, NULL, &c.out);
    shade_backward(&c, NULL, &grad, NULL, NULL);
    for (int i = 0; i < 45; i++) {
        assert_true(c.out.data[i] == c.gbuffer.ambient[i]);
        assert_true(grad.ambient[i] == c.weights.data[i]);
        assert_true(grad.albedo[i] == 0 && grad.normal[i] == 0);
    }
    ffp_gbuffer_free(&grad);
    free_shade_case(&c);
}

typedef struct WholeCase {
    RasterCase raster;
    ShadeCase shade;
} WholeCase;

static double whole_loss(void *context) {
    WholeCase *c = context;
    ffp_rasterise(c->raster.raster, &c->raster.gaussians, &c->shade.camera, &c->raster.settings,
                  &c->shade.gbuffer);
    return shade_loss(&c->shade);
}

// Gaussians to picture: rasterised, mapped once (its footprints and visibility are constants), shaded.
static void test_composition_gradients(void **state) {
    (void)state;
    WholeCase c = {.shade = shade_case(19, 13)};
    c.raster.raster = ffp_raster_new();
    c.raster.settings = ffp_render_defaults();
    c.raster.gaussians = random_gaussians(20, 11, 0.5, 0.05, 0.3, 0.3, 0.95);
    whole_loss(&c);
    FfpRaster *shadows = ffp_raster_new();
    ffp_map_to_projector(shadows, &c.raster.gaussians, &c.shade.gbuffer, &c.shade.camera, &c.shade.projector,
                         &c.raster.settings, &c.shade.mapping);
    whole_loss(&c);
    FfpSummed summed = ffp_summed_new(&c.shade.pattern);
    FfpGbuffer grad_gbuffer = ffp_gbuffer_new(19, 13);
    FfpGaussians grad = ffp_gaussians_new(20);
    shade_backward(&c.shade, &summed, &grad_gbuffer, NULL, NULL);
    ffp_rasterise_backward(c.raster.raster, &c.raster.gaussians, &c.shade.camera, &c.raster.settings,
                           &c.shade.gbuffer, &grad_gbuffer, &grad);
    Field fields[FIELDS], analytic[FIELDS];
    gaussian_fields(&c.raster.gaussians, fields);
    gaussian_fields(&grad, analytic);
    for (int k = 0; k < FIELDS; k++) check_field("composition", &fields[k], analytic[k].data, whole_loss, &c);
    ffp_summed_free(&summed);
    ffp_gbuffer_free(&grad_gbuffer);
    ffp_gaussians_free(&grad);
    ffp_gaussians_free(&c.raster.gaussians);
    ffp_raster_free(shadows);
    ffp_raster_free(c.raster.raster);
    free_shade_case(&c.shade);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_rasterise_gradients),   cmocka_unit_test(test_flat_and_opaque_gradients),
        cmocka_unit_test(test_off_centre_gradients),  cmocka_unit_test(test_held_jacobian_gradients),
        cmocka_unit_test(test_shade_gradients),       cmocka_unit_test(test_even_light_gradients),
        cmocka_unit_test(test_shade_edge_gradients),  cmocka_unit_test(test_shade_black),
        cmocka_unit_test(test_composition_gradients),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
