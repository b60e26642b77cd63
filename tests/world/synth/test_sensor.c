// The sensor model: nothing at all when it is off, and the right statistics when it is on.
#include <math.h>
#include "core/patterns/lollipop.h"
#include "support.h"
#include "world/synth/sensor.h"

static FfpSceneSpec small_spec(void) {
    FfpSceneSpec spec = ffp_scene_defaults();
    spec.mesh = 2, spec.material = 4, spec.seed = 5, spec.resolution = 40, spec.views = 2, spec.targets = 0;
    spec.lollipops = 1, spec.pattern_side = 160, spec.samples = 2;
    return spec;
}

static FfpCapture make(const FfpSceneSpec *spec) {
    FfpCapture capture;
    FfpError err;
    if (!ffp_scene_make(&capture, spec, &err)) fail_msg("%s", err.text);
    return capture;
}

static void off_is_the_identity(void **state) {
    (void)state;
    const FfpSensor off = {0};
    assert_false(ffp_sensor_changes_light(&off));
    for (uint32_t i = 0; i < 100; i++) {
        const float value = 0.013F * (float)i;
        assert_true(ffp_sensor_noise(value, 0, 0, i, 1) == value);
    }
    FfpImage image = ffp_lollipop_pattern(60, 60, 3), same = ffp_sensor_emit(&image, &off);
    for (int i = 0; i < 60 * 60 * 3; i++) assert_float_equal(image.data[i], same.data[i], 1e-7);
    ffp_image_free(&image);
    ffp_image_free(&same);
}

static void what_no_device_does_is_refused(void **state) {
    (void)state;
    FfpError err = {0};
    const FfpSensor good = {.exposure = -8, .shot = 1, .read = 1, .defocus = 64, .gamma = -0.9F};
    const FfpSensor wrong[] = {{.exposure = 9},      {.shot = -1e-3F},   {.read = NAN},
                               {.defocus = 65},      {.gamma = -1},      {.black_level = 1},
                               {.turn_error = 0.6F}, {.shift_error = -1}};
    assert_true(ffp_sensor_check(&good, &err));
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        assert_false(ffp_sensor_check(&wrong[i], &err));
        assert_non_null(strstr(err.text, "(sensor)"));
    }
}

static void noise_has_its_mean_and_variance(void **state) {
    (void)state;
    enum { COUNT = 40000 };
    static const float values[3] = {0, 0.1F, 0.7F}, shot = 2e-3F, read = 4e-3F;
    for (int v = 0; v < 3; v++) {
        double sum = 0, square = 0, fourth = 0, product = 0, before = 0;
        for (uint32_t i = 0; i < COUNT; i++) {
            const double error = (double)(ffp_sensor_noise(values[v], shot, read, i, 77) - values[v]);
            sum += error, square += error * error, fourth += error * error * error * error;
            product += error * before, before = error;
        }
        const double variance = (double)(shot * values[v] + read * read), got = square / COUNT;
        assert_true(fabs(sum / COUNT) < 4 * sqrt(variance / COUNT));
        assert_true(fabs(got / variance - 1) < 0.03);
        assert_true(fabs(fourth / COUNT / (got * got) - 3) < 0.15); // a normal's
        assert_true(fabs(product / COUNT / got) < 0.02);            // neighbours know nothing of each other
    }
    assert_true(ffp_sensor_noise(0.5F, shot, read, 1, 1) != ffp_sensor_noise(0.5F, shot, read, 1, 2));
}

static void defocus_is_a_gaussian(void **state) {
    (void)state;
    enum { SIDE = 41 };
    FfpImage point = ffp_image_new(SIDE, SIDE, 3);
    point.data[3 * (20 * SIDE + 20)] = 1;
    const FfpSensor sensor = {.defocus = 2.5F};
    FfpImage spread = ffp_sensor_emit(&point, &sensor);
    double total = 0, square[2] = {0, 0};
    for (int y = 0; y < SIDE; y++)
        for (int x = 0; x < SIDE; x++) {
            const double value = (double)spread.data[3 * (y * SIDE + x)];
            total += value, square[0] += value * (x - 20) * (x - 20),
                square[1] += value * (y - 20) * (y - 20);
            assert_true(spread.data[3 * (y * SIDE + x) + 1] == 0);
        }
    assert_float_equal(total, 1, 1e-4);
    assert_float_equal(sqrt(square[0]), 2.5, 0.05);
    assert_float_equal(sqrt(square[1]), 2.5, 0.05);
    ffp_image_free(&point);
    ffp_image_free(&spread);
}

static void projectors_bend_values_and_leak(void **state) {
    (void)state;
    FfpImage grey = ffp_image_new(4, 4, 3);
    for (int i = 0; i < 48; i++) grey.data[i] = (real)i / 47;
    const FfpSensor sensor = {.gamma = 0.5F, .black_level = 0.02F};
    FfpImage sent = ffp_sensor_emit(&grey, &sensor);
    for (int i = 0; i < 48; i++) assert_float_equal(sent.data[i], 0.02 + 0.98 * pow(i / 47.0, 1.5), 1e-5);
    ffp_image_free(&grey);
    ffp_image_free(&sent);
}

static void exposure_scales_light_and_intensity(void **state) {
    (void)state;
    FfpSceneSpec spec = small_spec();
    FfpCapture plain = make(&spec);
    spec.sensor.exposure = -1;
    FfpCapture dark = make(&spec);
    assert_float_equal(dark.intensity[0] / plain.intensity[0], 0.5, 1e-6);
    double error = 0, seen = 0;
    for (int i = 0; i < 40 * 40; i++) {
        const double a = (double)plain.views[0].images[0].data[3 * i],
                     b = (double)dark.views[0].images[0].data[3 * i];
        assert_float_equal(dark.views[0].direct_white.data[3 * i],
                           plain.views[0].direct_white.data[3 * i] / 2, 1e-5);
        if (plain.views[0].coverage.data[i] < 1 || a > 0.9) continue; // clipped
        error += fabs(b - a / 2), seen++;
    }
    assert_true(seen > 200 && error / seen < 0.003); // rounding to 8 bits
    ffp_capture_free(&plain);
    ffp_capture_free(&dark);
}

// In the pictures of a scene: the noise that was asked for, none where the object is not, other noise in
// each.
static void pictures_carry_the_noise(void **state) {
    (void)state;
    FfpSceneSpec spec = small_spec();
    FfpCapture plain = make(&spec);
    spec.sensor.shot = 1e-3F, spec.sensor.read = 5e-3F;
    FfpCapture noisy = make(&spec), again = make(&spec);
    double square = 0, expected = 0, cross = 0;
    for (int i = 0; i < 40 * 40 * 3; i++) {
        const FfpView *a = &plain.views[0], *b = &noisy.views[0];
        assert_true(b->images[0].data[i] == again.views[0].images[0].data[i]);
        if (a->coverage.data[i / 3] == 0) assert_true(b->images[0].data[i] == 0);
        const double value = (double)a->images[0].data[i], other = (double)a->images[1].data[i];
        if (a->coverage.data[i / 3] < 1 || value < 0.03 || value > 0.9 || other > 0.9) continue;
        const double error = (double)b->images[0].data[i] - value;
        square += error * error, cross += error * ((double)b->images[1].data[i] - other);
        expected += 1e-3 * value + 25e-6;
    }
    assert_true(expected > 0.01 && fabs(square / expected - 1) < 0.15);
    assert_true(fabs(cross) < 0.15 * square * 2);
    ffp_capture_free(&plain);
    ffp_capture_free(&noisy);
    ffp_capture_free(&again);
}

static void written_poses_err_and_stay_rigid(void **state) {
    (void)state;
    FfpSceneSpec spec = small_spec();
    FfpCapture plain = make(&spec);
    spec.sensor.turn_error = 0.01F, spec.sensor.shift_error = 0.02F;
    FfpCapture moved = make(&spec);
    for (int v = 0; v < 2; v++) { // the pictures are those of the true poses
        assert_memory_equal(plain.views[v].images[1].data, moved.views[v].images[1].data,
                            40 * 40 * 3 * sizeof(real));
        const real *p = plain.views[v].camera.pose, *q = moved.views[v].camera.pose;
        double dots[3][3] = {{0}}, shift = 0, trace = 0;
        for (int k = 0; k < 3; k++) {
            shift += pow((double)(q[4 * k + 3] - p[4 * k + 3]), 2);
            for (int a = 0; a < 3; a++) {
                trace += (double)(q[4 * k + a] * p[4 * k + a]);
                for (int b = 0; b < 3; b++) dots[a][b] += (double)(q[4 * k + a] * q[4 * k + b]);
            }
        }
        for (int a = 0; a < 3; a++)
            for (int b = 0; b < 3; b++) assert_float_equal(dots[a][b], a == b, 1e-5);
        const double turn = acos(fmin(1, (trace - 1) / 2));
        assert_true(turn > 1e-3 && turn < 0.05 && sqrt(shift) > 1e-3 && sqrt(shift) < 0.1);
    }
    FfpRng rng = ffp_rng(1, 1);
    double square = 0;
    for (int i = 0; i < 2000; i++) {
        FfpCamera device = {.pose = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}};
        ffp_sensor_misplace(&device, 0.01F, 0, &rng);
        square += (double)(device.pose[4] * device.pose[4]) / 2000; // the turn around z
        assert_true(device.pose[3] == 0);
    }
    assert_float_equal(sqrt(square), 0.01, 0.0006);
    ffp_capture_free(&plain);
    ffp_capture_free(&moved);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(off_is_the_identity),
        cmocka_unit_test(what_no_device_does_is_refused),
        cmocka_unit_test(noise_has_its_mean_and_variance),
        cmocka_unit_test(defocus_is_a_gaussian),
        cmocka_unit_test(projectors_bend_values_and_leak),
        cmocka_unit_test(exposure_scales_light_and_intensity),
        cmocka_unit_test(pictures_carry_the_noise),
        cmocka_unit_test(written_poses_err_and_stay_rigid),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
