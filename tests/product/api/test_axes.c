// Exported splats that come back from another program are turned into the capture's world again, in each of
// the formats, automatically or on request.
#include <math.h>
#include "core/gaussians/gaussians.h"
#include "initialised.h"

static FfpGaussians *exported(const char *name, FfpUp up) {
    FfpError err = {0};
    FfpExport how = ffp_export_defaults();
    how.file = in_scratch(name);
    how.up = up;
    if (!ffp_export(NULL, gaussians, capture, &how, NULL, &err)) fail_msg("%s", err.text);
    FfpGaussians *back = ffp_gaussians_open(NULL, in_scratch(name), NULL, &err);
    if (!back) fail_msg("%s", err.text);
    return back;
}

static double distance(const real *a, const real *b) {
    return sqrt(pow((double)(a[0] - b[0]), 2) + pow((double)(a[1] - b[1]), 2) +
                pow((double)(a[2] - b[2]), 2));
}

// Centres and the lengths of the axes' images agree: files keep the order.
static void expect_same(const FfpGaussians *back) {
    int64_t i = 0;
    for (int64_t k = 0; k < gaussians->count; k++) {
        if (gaussians->opacity[k] < FFP_OPACITY_LEAST) continue;
        assert_true(i < back->count);
        if (distance(back->centre + 3 * i, gaussians->centre + 3 * k) > 2e-3)
            fail_msg("Gaussian %d is elsewhere", (int)k);
        double dot = 0;
        for (int c = 0; c < 4; c++)
            dot += (double)(back->rotation[4 * i + c] * gaussians->rotation[4 * k + c]);
        if (fabs(dot) < 0.999) fail_msg("Gaussian %d is turned", (int)k);
        i++;
    }
}

static void round_trip(void **state) {
    (void)state;
    static const char *const names[] = {"a.ply", "a.spz", "a.glb"};
    FfpError err = {0};
    for (int i = 0; i < 3; i++) {
        FfpGaussians *back = exported(names[i], FFP_UP_Z);
        if (!ffp_gaussians_turn(NULL, back, in_scratch(names[i]), capture, NULL, &err))
            fail_msg("%s", err.text);
        expect_same(back);
        ffp_gaussians_close(back);
        back = exported(names[i], FFP_UP_Z);
        const FfpUp up = i == 0 ? FFP_UP_MINUS_Y : FFP_UP_Y;
        assert_true(ffp_gaussians_turn(NULL, back, in_scratch(names[i]), capture, &up, &err));
        expect_same(back);
        ffp_gaussians_close(back);
    }
}

// Splats in the capture's axes, and Gaussians of ours, stay.
static void what_fits_stays(void **state) {
    (void)state;
    FfpError err = {0};
    FfpGaussians *back = exported("same.glb", FFP_UP_Y);
    assert_true(ffp_gaussians_turn(NULL, back, in_scratch("same.glb"), capture, NULL, &err));
    expect_same(back);
    ffp_gaussians_close(back);
    assert_true(ffp_gaussians_save(NULL, gaussians, in_scratch("own.ply"), &err));
    back = ffp_gaussians_open(NULL, in_scratch("own.ply"), NULL, &err);
    const real before = back->centre[1];
    back->centre[1] = before + 5;
    assert_true(ffp_gaussians_turn(NULL, back, in_scratch("own.ply"), capture, NULL, &err));
    assert_true(back->centre[1] == before + 5);
    ffp_gaussians_close(back);
    const FfpUp wrong = (FfpUp)7;
    assert_false(ffp_gaussians_turn(NULL, gaussians, in_scratch("own.ply"), capture, &wrong, &err));
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(round_trip), cmocka_unit_test(what_fits_stays)};
    return cmocka_run_group_tests(tests, setup, teardown);
}
