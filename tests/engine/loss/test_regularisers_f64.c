// The terms on G-buffers: gradients to every input, and the values of small cases counted by hand.
#include "core/base/alloc.h"
#include "engine/loss/loss.h"
#include "gradcheck.h"

enum { WIDTH = 9, HEIGHT = 7, PIXELS = WIDTH * HEIGHT };

typedef struct Maps {
    real *opacity, *mask, *depth, *truth, *normal, *roughness, *albedo, *distortion;
} Maps;

static Maps new_maps(void) {
    Maps maps = {.opacity = random_values(PIXELS, 1, 0.02F, 0.98F),
                 .mask = random_values(PIXELS, 2, 0, 1),
                 .depth = random_values(PIXELS, 3, 1, 3),
                 .truth = random_values(PIXELS, 4, -1, 3),
                 .normal = random_values(PIXELS * 3, 5, -0.5F, 0.5F),
                 .roughness = random_values(PIXELS, 6, 0, 1),
                 .albedo = random_values(PIXELS * 3, 7, 0, 1),
                 .distortion = random_values(PIXELS, 8, 0, 1)};
    for (int i = 0; i < PIXELS; i++)
        maps.mask[i] = i % 5 == 0 ? 0.3 * maps.mask[i] : fmin(1, 0.6 + maps.mask[i]);
    return maps;
}

static void free_maps(Maps *m) {
    real *all[] = {m->opacity, m->mask,      m->depth,  m->truth,
                   m->normal,  m->roughness, m->albedo, m->distortion};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) ffp_free(all[i]);
}

static double mask_loss(void *context) {
    const Maps *m = context;
    return ffp_mask_loss(m->opacity, m->mask, PIXELS, 0.7, NULL);
}

static double depth_loss(void *context) {
    const Maps *m = context;
    return ffp_depth_loss(m->depth, m->opacity, m->truth, PIXELS, 0.7, NULL, NULL);
}

static double distortion_loss(void *context) {
    const Maps *m = context;
    return ffp_distortion_loss(m->distortion, PIXELS, 0.7, NULL);
}

static double normal_loss(void *context) {
    const Maps *m = context;
    return ffp_normal_smooth_loss(m->normal, m->mask, WIDTH, HEIGHT, 0.7, NULL);
}

static double roughness_loss(void *context) {
    const Maps *m = context;
    return ffp_roughness_loss(m->roughness, m->albedo, m->opacity, m->mask, WIDTH, HEIGHT, 0.7, NULL, NULL);
}

static void test_mask(void **state) {
    (void)state;
    Maps m = new_maps();
    m.opacity[3] = 0, m.opacity[4] = 1; // clamped: finite, and no slope
    real *grad = new_gradient(PIXELS);
    const double value = ffp_mask_loss(m.opacity, m.mask, PIXELS, 0.7, grad);
    assert_true(isfinite(value) && value > 0);
    assert_true(grad[3] == GRAD_START && grad[4] == GRAD_START);
    check_gradient("opacity", mask_loss, &m, m.opacity, grad, PIXELS, 1, 1e-7, 1e-6);
    ffp_free(grad);
    free_maps(&m);
    const real half[2] = {0.5, 0.5}, truth[2] = {1, 0};
    assert_true(fabs(ffp_mask_loss(half, truth, 2, 1, NULL) - log(2)) < 1e-12);
}

static void test_depth(void **state) {
    (void)state;
    Maps m = new_maps();
    real *grad_depth = new_gradient(PIXELS), *grad_opacity = new_gradient(PIXELS);
    const double value = ffp_depth_loss(m.depth, m.opacity, m.truth, PIXELS, 0.7, grad_depth, grad_opacity);
    double sum = 0;
    int count = 0;
    for (int i = 0; i < PIXELS; i++)
        if (m.truth[i] > 0 && m.opacity[i] > 0.5)
            sum += pow(m.depth[i] / m.opacity[i] - m.truth[i], 2), count++;
    assert_true(count > 0 && fabs(value - 0.7 * sum / count) < 1e-12);
    check_gradient("depth", depth_loss, &m, m.depth, grad_depth, PIXELS, 1, 1e-6, 1e-6);
    check_gradient("opacity", depth_loss, &m, m.opacity, grad_opacity, PIXELS, 1, 1e-6, 1e-6);
    for (int i = 0; i < PIXELS; i++) m.truth[i] = 0;
    assert_true(depth_loss(&m) == 0);
    ffp_free(grad_depth);
    ffp_free(grad_opacity);
    free_maps(&m);
}

static void test_distortion(void **state) {
    (void)state;
    Maps m = new_maps();
    real *grad = new_gradient(PIXELS);
    double sum = 0;
    for (int i = 0; i < PIXELS; i++) sum += m.distortion[i];
    assert_true(fabs(ffp_distortion_loss(m.distortion, PIXELS, 0.7, grad) - 0.7 * sum / PIXELS) < 1e-12);
    check_gradient("distortion", distortion_loss, &m, m.distortion, grad, PIXELS, 1, 1e-6, 1e-6);
    ffp_free(grad);
    free_maps(&m);
}

static void test_normal(void **state) {
    (void)state;
    Maps m = new_maps();
    for (int c = 0; c < 3; c++) m.normal[3 * 12 + c] = 0; // a foreground pixel that nothing covers
    real *grad = new_gradient((size_t)PIXELS * 3);
    assert_true(ffp_normal_smooth_loss(m.normal, m.mask, WIDTH, HEIGHT, 0.7, grad) > 0);
    assert_true(grad[36] == GRAD_START && grad[37] == GRAD_START && grad[38] == GRAD_START);
    check_gradient("normal", normal_loss, &m, m.normal, grad, 36, 1, 1e-6, 1e-6);
    check_gradient("normal", normal_loss, &m, m.normal + 39, grad + 39, PIXELS * 3 - 39, 1, 1e-6, 1e-6);
    ffp_free(grad);
    free_maps(&m);
}

// Three pixels in a row and one below: unit normals x, y, y / y, whatever the lengths of the sums. Pairs:
// x-y, y-y, x-y.
static void test_normal_value(void **state) {
    (void)state;
    const real normal[18] = {0.5, 0, 0, 0, 0.9, 0, 0, 0.2, 0, 0, 1, 0};
    real mask[6] = {1, 1, 1, 1, 0, 0};
    assert_true(fabs(ffp_normal_smooth_loss(normal, mask, 3, 2, 3, NULL) - 4) < 1e-12);
    mask[0] = 0; // only y-y is left
    assert_true(ffp_normal_smooth_loss(normal, mask, 3, 2, 3, NULL) == 0);
}

static void test_roughness(void **state) {
    (void)state;
    Maps m = new_maps();
    real *grad = new_gradient(PIXELS), *grad_opacity = new_gradient(PIXELS);
    assert_true(ffp_roughness_loss(m.roughness, m.albedo, m.opacity, m.mask, WIDTH, HEIGHT, 0.7, grad, NULL) >
                0);
    check_gradient("roughness", roughness_loss, &m, m.roughness, grad, PIXELS, 1, 1e-6, 1e-6);
    // The albedo is a constant of the loss: for the opacity's gradient it must move along, so that A / O
    // stands still.
    for (int i = 0; i < PIXELS * 3; i++) m.albedo[i] = 0;
    ffp_free(grad);
    ffp_roughness_loss(m.roughness, m.albedo, m.opacity, m.mask, WIDTH, HEIGHT, 0.7, NULL, grad_opacity);
    check_gradient("opacity", roughness_loss, &m, m.opacity, grad_opacity, PIXELS, 1, 1e-6, 1e-6);
    ffp_free(grad_opacity);
    free_maps(&m);
}

static void test_roughness_value(void **state) {
    (void)state;
    const real roughness[2] = {0.4, 0.1}, opacity[2] = {0.8, 0.5}; // 0.5 and 0.2
    const real albedo[6] = {0.8, 0.4, 0, 0.4, 0.25, 0};            // (1, 0.5, 0) and (0.8, 0.5, 0)
    real mask[2] = {1, 1};
    const double value = ffp_roughness_loss(roughness, albedo, opacity, mask, 2, 1, 2, NULL, NULL);
    assert_true(fabs(value - 2 * 0.3 * exp(-0.2)) < 1e-12);
    mask[1] = 0;
    assert_true(ffp_roughness_loss(roughness, albedo, opacity, mask, 2, 1, 2, NULL, NULL) == 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_mask),
        cmocka_unit_test(test_depth),
        cmocka_unit_test(test_distortion),
        cmocka_unit_test(test_normal),
        cmocka_unit_test(test_normal_value),
        cmocka_unit_test(test_roughness),
        cmocka_unit_test(test_roughness_value),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
