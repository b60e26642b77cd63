// Convolution and pooling of the perceptual networks against loops that follow the definition.
#include "core/base/alloc.h"
#include "engine/loss/conv.h"
#include "gradcheck.h"

// Sizes chosen so that some take one strip, some several, some more rows than the strip's pixels ask for.
static const FfpConv convolutions[] = {
    {.in = 3, .out = 5, .kernel = 3, .stride = 1, .pad = 1, .width = 37, .height = 29},
    {.in = 2, .out = 4, .kernel = 3, .stride = 2, .pad = 0, .width = 70, .height = 23},
    {.in = 3, .out = 2, .kernel = 11, .stride = 4, .pad = 2, .width = 201, .height = 47},
    {.in = 2, .out = 3, .kernel = 5, .stride = 1, .pad = 2, .width = 90, .height = 17},
    {.in = 7, .out = 3, .kernel = 1, .stride = 1, .pad = 0, .width = 61, .height = 9},
    {.in = 2, .out = 2, .kernel = 5, .stride = 1, .pad = 2, .width = 2, .height = 1},
    {.in = 1, .out = 2, .kernel = 3, .stride = 2, .pad = 1, .width = 300, .height = 7},
};
enum { CONVOLUTIONS = sizeof convolutions / sizeof *convolutions };

typedef struct Sizes {
    int width, height; // output
    size_t x, y, w;
} Sizes;

static Sizes sizes_of(const FfpConv *s) {
    Sizes z = {.width = ffp_conv_side(s->width, s->kernel, s->stride, s->pad),
               .height = ffp_conv_side(s->height, s->kernel, s->stride, s->pad)};
    z.x = (size_t)s->in * s->width * s->height;
    z.y = (size_t)s->out * z.width * z.height;
    z.w = (size_t)s->out * s->in * s->kernel * s->kernel;
    return z;
}

// Walks all (output, tap) pairs: y += w x if `forward`, otherwise x += w y.
static void plain_conv(real *y, real *x, const real *w, const FfpConv *s, const Sizes *z, bool forward) {
    for (int o = 0; o < s->out; o++)
        for (int p = 0; p < z->width * z->height; p++)
            for (int k = 0; k < s->in * s->kernel * s->kernel; k++) {
                const int j = k % s->kernel, i = k / s->kernel % s->kernel, c = k / s->kernel / s->kernel;
                const int u = p % z->width * s->stride - s->pad + j,
                          v = p / z->width * s->stride - s->pad + i;
                if (u < 0 || v < 0 || u >= s->width || v >= s->height) continue;
                real *from = &x[((size_t)c * s->height + v) * s->width + u];
                real *to = &y[(size_t)o * z->width * z->height + p];
                const real weight = w[(size_t)o * s->in * s->kernel * s->kernel + k];
                if (forward)
                    *to += weight * *from;
                else
                    *from += weight * *to;
            }
}

static double largest_difference(const real *a, const real *b, size_t count) {
    double largest = 0;
    for (size_t i = 0; i < count; i++) largest = worse(largest, fabs(a[i] - b[i]));
    return largest;
}

static void check_forward(const FfpConv *s, uint64_t seed) {
    const Sizes z = sizes_of(s);
    const size_t step = z.y + 5; // images need not be packed
    real *x = random_values(2 * z.x, seed, -1, 1), *w = random_values(z.w, seed + 1, -1, 1);
    real *bias = random_values(s->out, seed + 2, -1, 1);
    real *y = random_values(2 * step, seed + 3, -1, 1), *truth = ffp_alloc(z.y, sizeof *truth);
    ffp_conv2d_forward(y, step, x, z.x, w, bias, s, 2);
    for (int image = 0; image < 2; image++) {
        for (size_t i = 0; i < z.y; i++) truth[i] = bias[i / ((size_t)z.width * z.height)];
        plain_conv(truth, x + image * z.x, w, s, &z, true);
        for (size_t i = 0; i < z.y; i++) truth[i] = fmax(truth[i], 0);
        assert_true(largest_difference(y + image * step, truth, z.y) < 1e-11);
    }
    ffp_free(x), ffp_free(w), ffp_free(bias), ffp_free(y), ffp_free(truth);
}

static void check_backward(const FfpConv *s, uint64_t seed) {
    const Sizes z = sizes_of(s);
    real *w = random_values(z.w, seed, -1, 1), *y = random_values(z.y, seed + 1, -1, 1);
    real *dy = random_values(z.y, seed + 2, -1, 1), *masked = ffp_alloc(z.y, sizeof *masked);
    real *dx = new_gradient(z.x), *truth = new_gradient(z.x);
    for (size_t i = 0; i < z.y; i++) {
        y[i] = fmax(y[i], 0);
        masked[i] = y[i] > 0 ? dy[i] : 0;
    }
    ffp_conv2d_backward(dx, dy, y, w, s);
    plain_conv(masked, truth, w, s, &z, false);
    assert_true(largest_difference(dx, truth, z.x) < 1e-11);
    assert_true(largest_difference(dy, masked, z.y) == 0);
    ffp_free(w), ffp_free(y), ffp_free(dy), ffp_free(masked), ffp_free(dx), ffp_free(truth);
}

static void test_forward(void **state) {
    (void)state;
    for (int i = 0; i < CONVOLUTIONS; i++) check_forward(&convolutions[i], 10 * i);
}

static void test_backward(void **state) {
    (void)state;
    for (int i = 0; i < CONVOLUTIONS; i++) check_backward(&convolutions[i], 10 * i);
}

static void test_sides(void **state) {
    (void)state;
    assert_int_equal(ffp_conv_side(128, 11, 4, 2), 31);
    assert_int_equal(ffp_conv_side(2, 3, 2, 0), 0);
    assert_int_equal(ffp_pool_side(31, 3, 2, false), 15);
    assert_int_equal(ffp_pool_side(32, 3, 2, false), 15);
    assert_int_equal(ffp_pool_side(32, 3, 2, true), 16);
    assert_int_equal(ffp_pool_side(2, 3, 2, true), 1);
    assert_int_equal(ffp_pool_side(1, 3, 2, true), 0);
    assert_int_equal(ffp_pool_side(2, 3, 2, false), 0);
}

static void test_pool(void **state) {
    (void)state;
    const FfpPool pool = {.channels = 2, .kernel = 3, .stride = 2, .round_up = true, .width = 4, .height = 2};
    const real x[16] = {1, 5, 2, 3, 4, 0, 5, 6, -1, -2, -3, -4, -5, -6, -7, -1}, dy[4] = {10, 20, 30, 40};
    real y[4], dx[16] = {0};
    ffp_maxpool_forward(y, x, &pool);
    const real largest[4] = {5, 6, -1, -1}; // the second window of each row is clipped to two columns
    assert_true(largest_difference(y, largest, 4) == 0);
    dx[1] = 1;
    ffp_maxpool_backward(dx, dy, x, &pool);
    real truth[16] = {0};
    truth[1] = 11, truth[7] = 20, truth[8] = 30, truth[15] = 40; // the first of two fives gets it
    assert_true(largest_difference(dx, truth, 16) == 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_forward), cmocka_unit_test(test_backward),
                                       cmocka_unit_test(test_sides), cmocka_unit_test(test_pool)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
