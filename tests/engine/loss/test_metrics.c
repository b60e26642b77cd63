// PSNR against values that can be counted by hand.
#include <math.h>
#include "engine/loss/metrics.h"
#include "support.h"

static void test_psnr(void **state) {
    (void)state;
    FfpImage a = ffp_image_new(7, 5, 3), b = ffp_image_new(7, 5, 3);
    for (int i = 0; i < 105; i++) a.data[i] = 0.25F, b.data[i] = 0.35F;
    assert_true(fabs(ffp_psnr(&a, &b) - 20) < 1e-4); // MSE 0.01
    for (int i = 0; i < 105; i++) b.data[i] = i == 31 ? 0.75F : 0.25F;
    assert_true(fabs(ffp_psnr(&a, &b) - 10 * log10(105 / 0.25)) < 1e-4); // one value of 105 differs
    assert_true(ffp_psnr(&a, &a) == FFP_PSNR_CAP);
    for (int i = 0; i < 105; i++) b.data[i] = 0.25F + 1e-7F;
    assert_true(ffp_psnr(&a, &b) == FFP_PSNR_CAP);
    b.data[50] = NAN;
    assert_true(isnan(ffp_psnr(&a, &b)));
    ffp_image_free(&a);
    ffp_image_free(&b);
}

static void test_psnr_masked(void **state) {
    (void)state;
    FfpImage a = ffp_image_new(4, 3, 3), b = ffp_image_new(4, 3, 3), mask = ffp_image_new(4, 3, 1);
    assert_true(isnan(ffp_psnr_masked(&a, &b, &mask)));
    for (int i = 0; i < 12; i++)
        for (int c = 0; c < 3; c++) b.data[3 * i + c] = i < 5 ? 0.1F : 1;
    for (int i = 0; i < 12; i++) mask.data[i] = i < 5 ? 0.6F : 0.5F;
    assert_true(fabs(ffp_psnr_masked(&a, &b, &mask) - 20) < 1e-4);
    for (int i = 0; i < 12; i++) mask.data[i] = 1;
    assert_true(ffp_psnr_masked(&a, &b, &mask) == ffp_psnr(&a, &b));
    ffp_image_free(&a);
    ffp_image_free(&b);
    ffp_image_free(&mask);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_psnr), cmocka_unit_test(test_psnr_masked)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
