// Corners to optics and motion, without pictures: many attitudes out of line, and rays through strong lenses.
#include "attitudes.h"
#include "rig/chessboard/pose.h"

enum { ATTITUDES = 28, BAD = 12 };
#define NEEDS_OPENCV()                                                                                       \
    (void)state;                                                                                             \
    if (!ffp_cv_available(NULL)) skip()

static double turn_off(const double r[9]) {
    double truth[9], difference[9], v[3];
    ffp_rotation_from_vector(true_turn, truth);
    ffp_rotation_difference(r, truth, difference);
    ffp_rotation_to_vector(difference, v);
    return sqrt(ffp_dot(v, v)) * 180 / FFP_PI_DOUBLE;
}

// Of the bad ones, one half has corners astray in the camera; with the others the board moved before the
// projector's codes, which only both devices together tell.
static FfpRigFit spoilt_rig(void) {
    FfpRng rng = ffp_rng(3, 1);
    FfpRigFit fit = new_rig_fit(ATTITUDES);
    fit.fixed[0] = fit.fixed[1] = FFP_CV_FIX_K3;
    for (int i = 0; i < ATTITUDES; i++) {
        const bool bad = i % 2 == 1 && i < 2 * BAD;
        fit.attitudes[i] = new_attitude("board", 0.05, &rng);
        for (int k = 0; bad && k < 2 * fit.attitudes[i].n; k++) {
            if (i % 4 == 1)
                fit.attitudes[i].camera[k] += (3 + 0.2 * i) * (double)ffp_rng_normal(&rng);
            else
                fit.attitudes[i].projector[k] += (k % 2 ? 1 : -1) * (i % 8 == 3 ? 1 : -1) * (4 + 0.2 * i);
        }
    }
    return fit;
}

static void however_many_are_out_of_line(void **state) {
    NEEDS_OPENCV();
    FfpRigFit fit = spoilt_rig();
    FfpError err = {0};
    if (!ffp_fit_rig(&fit, &err)) fail_msg("%s", err.text);
    printf("%d used, rms %.3f, turn off by %.3f degrees, shift %.2f %.2f %.2f\n", ffp_attitudes_used(&fit),
           fit.rms, turn_off(fit.r), fit.t[0], fit.t[1], fit.t[2]);
    for (int i = 0; i < ATTITUDES; i++)
        assert_int_equal(fit.attitudes[i].problem[0] != 0, i % 2 == 1 && i < 2 * BAD);
    assert_true(fit.rms > 0.01 && fit.rms < 0.1);
    assert_true(turn_off(fit.r) < 0.1);
    for (int i = 0; i < 3; i++) assert_true(fabs(fit.t[i] - true_shift[i]) < 4);
    ffp_rig_fit_free(&fit);
}

static void check_ray(const double lens[5], double x, double y) {
    FfpCvDevice device = true_devices[0];
    const double point[3] = {x, y, 1};
    double pixel[2], ray[2];
    memcpy(device.lens, lens, sizeof device.lens);
    ffp_device_project(&device, point, pixel);
    assert_true(ffp_device_ray(&device, pixel, ray));
    assert_true(fabs(ray[0] - x) < 1e-6 && fabs(ray[1] - y) < 1e-6);
}

static void strong_lenses_have_rays(void **state) {
    (void)state;
    static const double sharp[5] = {0, 0, 0, 0, 60}, cushion[5] = {0.45},
                        mild[5] = {-0.18, 0.11, 0.001, 0, 0};
    check_ray(sharp, 0.42, 0.30);
    check_ray(cushion, 0.75, 0.5);
    check_ray(mild, -0.3, 0.2);
}

// A barrel that folds over: nothing is seen beyond its edge.
static void no_ray_is_told(void **state) {
    (void)state;
    FfpCvDevice device = true_devices[0];
    const double barrel[5] = {-1}, pixel[2] = {247 + 620 * 0.42, 174 + 615 * 0.126};
    double ray[2];
    memcpy(device.lens, barrel, sizeof device.lens);
    assert_false(ffp_device_ray(&device, pixel, ray));
}

// Corners without a ray give no pose.
static void a_board_without_rays_has_no_pose(void **state) {
    NEEDS_OPENCV();
    FfpRng rng = ffp_rng(5, 1);
    FfpCvDevice device = true_devices[0];
    FfpAttitude a = new_attitude("board", 0, &rng);
    FfpBoardPose pose;
    bool found = false;
    assert_true(ffp_board_pose(&chessboard, &device, &a, &pose, &found, NULL));
    assert_true(found && pose.rms < 1e-3);
    device.lens[0] = NAN;
    assert_true(ffp_board_pose(&chessboard, &device, &a, &pose, &found, NULL));
    assert_false(found);
    ffp_attitude_free(&a);
}

// By the projector alone, or by both together where each alone fits; a rig that moved leaves both as they
// are.
static void bent_projectors_are_told(void **state) {
    (void)state;
    static const double rms[5][3] = {
        {0.16, 0.66, 1.5}, {0.16, 0.26, 0.34}, {0.16, 0.16, 0.17}, {0.16, 0.2, 0.9}, {0.05, 0.25, 0.2}};
    for (int i = 0; i < 5; i++) {
        const FfpRigFit fit = {.devices = {{.rms = rms[i][0]}, {.rms = rms[i][1]}}, .rms = rms[i][2]};
        assert_int_equal(ffp_projector_bent(&fit), i < 2);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(however_many_are_out_of_line), cmocka_unit_test(strong_lenses_have_rays),
        cmocka_unit_test(no_ray_is_told), cmocka_unit_test(a_board_without_rays_has_no_pose),
        cmocka_unit_test(bent_projectors_are_told)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
