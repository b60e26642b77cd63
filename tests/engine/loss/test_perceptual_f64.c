// The perceptual networks with random weights: gradients to the image, in double, on odd sizes.
#include "core/base/alloc.h"
#include "engine/loss/perceptual_net.h"
#include "gradcheck.h"
#include "random_perceptual.h"

typedef struct Case {
    FfpPerceptual *net;
    FfpImage a, b;
} Case;

static double distance(void *context) {
    const Case *c = context;
    return ffp_perceptual_loss(c->net, &c->a, &c->b, 0.7, NULL);
}

static void check_network(FfpPerceptualKind kind, int width, int height, int every) {
    const int values = width * height * 3;
    Case c = {.net = random_perceptual(kind),
              .a = {width, height, 3, random_values(values, 1, 0, 1)},
              .b = {width, height, 3, random_values(values, 2, 0, 1)}};
    FfpImage grad = {width, height, 3, new_gradient(values)};
    const double value = ffp_perceptual_loss(c.net, &c.a, &c.b, 0.7, &grad);
    assert_true(value > 0 && value == distance(&c));
    check_gradient("image", distance, &c, c.a.data, grad.data, values, every, 1e-7, 1e-5);
    ffp_free(c.b.data);
    c.b.data = c.a.data;
    assert_true(distance(&c) <
                1e-20); // not quite 0: fused multiply-adds round one of two equal features only
    ffp_free(c.a.data);
    ffp_free(grad.data);
    ffp_perceptual_free(c.net);
}

static void test_alex(void **state) {
    (void)state;
    check_network(FFP_PERCEPTUAL_ALEX, 39, 35, 67);
}

static void test_squeeze(void **state) {
    (void)state;
    check_network(FFP_PERCEPTUAL_SQUEEZE, 23, 27, 13);
}

static void test_vgg16(void **state) {
    (void)state;
    check_network(FFP_PERCEPTUAL_VGG16, 13, 9, 5);
}

static void test_least_side(void **state) {
    (void)state;
    const int least[] = {31, 17, 2};
    for (int kind = FFP_PERCEPTUAL_ALEX; kind <= FFP_PERCEPTUAL_VGG16; kind++) {
        FfpPerceptual *net = random_perceptual(kind);
        const int side = ffp_perceptual_least_side(net);
        assert_int_equal(side, least[kind]);
        assert_int_equal(ffp_perceptual_is_lpips(net), kind != FFP_PERCEPTUAL_VGG16);
        FfpImage a = {side, side, 3, random_values((size_t)side * side * 3, 1, 0, 1)};
        FfpImage b = {side, side, 3, random_values((size_t)side * side * 3, 2, 0, 1)};
        FfpImage grad = {side, side, 3, new_gradient((size_t)side * side * 3)};
        assert_true(ffp_perceptual_loss(net, &a, &b, 1, NULL) > 0);
        a.height = b.height = grad.height = side - 1;
        assert_true(ffp_perceptual_loss(net, &a, &b, 1, &grad) == 0 && grad.data[0] == GRAD_START);
        ffp_free(a.data), ffp_free(b.data), ffp_free(grad.data);
        ffp_perceptual_free(net);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_alex), cmocka_unit_test(test_squeeze),
                                       cmocka_unit_test(test_vgg16), cmocka_unit_test(test_least_side)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
