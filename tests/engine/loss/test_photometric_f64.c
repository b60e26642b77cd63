// L1, SSIM and the sRGB slope: values against plain sums, gradients against central differences.
#include "core/base/alloc.h"
#include "engine/loss/loss.h"
#include "gradcheck.h"

enum { WIDTH = 19, HEIGHT = 14, VALUES = WIDTH * HEIGHT * 3 };

typedef struct Case {
    FfpImage a, b;
    real weight;
} Case;

static FfpImage random_image(int width, int height, int channels, uint64_t seed) {
    return (FfpImage){width, height, channels, random_values((size_t)width * height * channels, seed, 0, 1)};
}

static Case new_case(void) {
    return (Case){
        .a = random_image(WIDTH, HEIGHT, 3, 1), .b = random_image(WIDTH, HEIGHT, 3, 2), .weight = 0.7};
}

static void free_case(Case *c) {
    ffp_free(c->a.data);
    ffp_free(c->b.data);
}

static double l1(void *context) {
    const Case *c = context;
    return ffp_l1_loss(&c->a, &c->b, c->weight, NULL);
}

static double square(void *context) {
    const Case *c = context;
    return ffp_square_loss(&c->a, &c->b, c->weight, NULL);
}

static double ssim(void *context) {
    const Case *c = context;
    return ffp_ssim_loss(&c->a, &c->b, c->weight, NULL);
}

static void test_l1_value(void **state) {
    (void)state;
    Case c = new_case();
    double sum = 0;
    for (int i = 0; i < VALUES; i++) sum += fabs(c.a.data[i] - c.b.data[i]);
    assert_true(fabs(l1(&c) - 0.7 * sum / VALUES) < 1e-12);
    free_case(&c);
}

static void test_l1_gradient(void **state) {
    (void)state;
    Case c = new_case();
    FfpImage grad = {WIDTH, HEIGHT, 3, new_gradient(VALUES)};
    ffp_l1_loss(&c.a, &c.b, c.weight, &grad);
    check_gradient("l1", l1, &c, c.a.data, grad.data, VALUES, 1, 1e-6, 1e-6);
    ffp_free(grad.data);
    free_case(&c);
}

static void test_square(void **state) {
    (void)state;
    Case c = new_case();
    double sum = 0;
    for (int i = 0; i < VALUES; i++) sum += (c.a.data[i] - c.b.data[i]) * (c.a.data[i] - c.b.data[i]);
    assert_true(fabs(square(&c) - 0.7 * sum / VALUES) < 1e-12);
    FfpImage grad = {WIDTH, HEIGHT, 3, new_gradient(VALUES)};
    ffp_square_loss(&c.a, &c.b, c.weight, &grad);
    check_gradient("square", square, &c, c.a.data, grad.data, VALUES, 1, 1e-6, 1e-6);
    ffp_free(grad.data);
    free_case(&c);
}

// The index by its definition: a two-dimensional window at every pixel, what lies outside the picture being
// zero.
static double plain_ssim(const FfpImage *a, const FfpImage *b) {
    double window[11], total = 0, sum = 0;
    for (int k = 0; k < 11; k++) total += window[k] = exp(-(k - 5) * (k - 5) / (2 * 1.5 * 1.5));
    for (int k = 0; k < 11; k++) window[k] /= total;
    for (int i = 0; i < a->width * a->height * a->channels; i++) {
        const int c = i % a->channels, x = i / a->channels % a->width, y = i / a->channels / a->width;
        double m[5] = {0};
        for (int v = 0; v < 11; v++)
            for (int u = 0; u < 11; u++) {
                const int px = x + u - 5, py = y + v - 5;
                if (px < 0 || py < 0 || px >= a->width || py >= a->height) continue;
                const int at = (py * a->width + px) * a->channels + c;
                const double w = window[u] * window[v], p = a->data[at], q = b->data[at];
                m[0] += w * p, m[1] += w * q, m[2] += w * p * p, m[3] += w * q * q, m[4] += w * p * q;
            }
        const double va = m[2] - m[0] * m[0], vb = m[3] - m[1] * m[1], cov = m[4] - m[0] * m[1];
        sum += (2 * m[0] * m[1] + 1e-4) * (2 * cov + 9e-4) /
               ((m[0] * m[0] + m[1] * m[1] + 1e-4) * (va + vb + 9e-4));
    }
    return sum / (a->width * a->height * a->channels);
}

static void test_ssim_value(void **state) {
    (void)state;
    const int shapes[][3] = {{19, 14, 3}, {1, 1, 1}, {5, 30, 1}, {33, 4, 4}};
    for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++) {
        FfpImage a = random_image(shapes[i][0], shapes[i][1], shapes[i][2], 3 + i);
        FfpImage b = random_image(shapes[i][0], shapes[i][1], shapes[i][2], 30 + i);
        assert_true(fabs(ffp_ssim(&a, &b) - plain_ssim(&a, &b)) < 1e-8);
        assert_true(fabs(ffp_ssim_loss(&a, &b, 2, NULL) - 2 * (1 - plain_ssim(&a, &b))) < 1e-8);
        assert_true(fabs(ffp_ssim(&a, &a) - 1) < 1e-12);
        ffp_free(a.data);
        ffp_free(b.data);
    }
}

static void test_ssim_gradient(void **state) {
    (void)state;
    Case c = new_case();
    FfpImage grad = {WIDTH, HEIGHT, 3, new_gradient(VALUES)};
    ffp_ssim_loss(&c.a, &c.b, c.weight, &grad);
    check_gradient("ssim", ssim, &c, c.a.data, grad.data, VALUES, 1, 1e-5, 1e-6);
    ffp_free(grad.data);
    free_case(&c);
}

// The derivative behind losses on encoded pictures: the curve's slope, 0 outside [0,1].
static void test_srgb_slope(void **state) {
    (void)state;
    for (double x = -0.2015; x < 1.3; x += 0.003) {
        const double h = 1e-7, slope = (ffp_srgb_encode(x + h) - ffp_srgb_encode(x - h)) / (2 * h);
        assert_true(fabs(ffp_srgb_encode_slope(x) - slope) < 1e-5);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_l1_value),   cmocka_unit_test(test_l1_gradient),
        cmocka_unit_test(test_ssim_value), cmocka_unit_test(test_ssim_gradient),
        cmocka_unit_test(test_square),     cmocka_unit_test(test_srgb_slope),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
