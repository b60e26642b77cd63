// The object's sphere where camera and projector look nearly the same way, so that their axes do not tell how
// far away it is: simulated rigs, and a real chessboard.
#include <stdio.h>
#include <tgmath.h>
#include "core/base/arena.h"
#include "core/base/rng.h"
#include "core/image/lookup.h"
#include "rig/checks/checks.h"
#include "rig/import/import.h"
#include "rig/optics/lens.h"
#include "scratch.h"

#define SIDE 96
#define PATTERN 200
#define CELL 8 // of the pattern's coloured squares

typedef struct Rig {
    real distance, radius; // of a ball before the first camera; radius 0: a wall
    real baseline, toe_in; // of the projector beside the camera; radians towards it
    real shift;            // of its principal point, share of its picture
    int views;             // cameras side by side
} Rig;

static void turn_about_y(FfpCamera *device, real angle) {
    device->pose[0] = device->pose[10] = cos(angle);
    device->pose[2] = sin(angle), device->pose[8] = -sin(angle);
}

static FfpCamera device(int side, real focal, real x, real angle, real shift) {
    FfpCamera out = {.width = side, .height = side, .fx = focal, .fy = focal};
    out.cx = (real)side / 2, out.cy = (real)side * (0.5F + shift);
    for (int i = 0; i < 16; i += 5) out.pose[i] = 1;
    out.pose[3] = x;
    turn_about_y(&out, -angle);
    return out;
}

static FfpImage squares(void) {
    FfpImage image = ffp_image_new(PATTERN, PATTERN, 3);
    for (int i = 0; i < PATTERN * PATTERN * 3; i++) {
        const int x = i / 3 % PATTERN / CELL, y = i / 3 / PATTERN / CELL;
        FfpRng rng = ffp_rng(7, (uint64_t)(3 * (y * PATTERN + x) + i % 3));
        image.data[i] = ffp_rng_uniform(&rng);
    }
    return image;
}

// Where the pixel's ray meets the ball or the wall; false when it does not.
static bool meet(const Rig *rig, const FfpCamera *camera, int x, int y, real point[3]) {
    real ray[3], b = 0, c = -rig->radius * rig->radius, t;
    const real *pose = camera->pose, centre[3] = {0, 0, rig->distance};
    ffp_pixel_ray(camera, (real)x + 0.5F, (real)y + 0.5F, ray);
    for (int i = 0; i < 3; i++) {
        const real to = pose[4 * i + 3] - centre[i];
        b += to * ray[i], c += to * to;
    }
    t = rig->radius > 0 ? -b - sqrt(b * b - c) : rig->distance / ray[2];
    for (int i = 0; i < 3; i++) point[i] = pose[4 * i + 3] + t * ray[i];
    return rig->radius == 0 || b * b > c;
}

static void photograph(const Rig *rig, const FfpCapture *capture, FfpView *view) {
    FfpSummed pattern = ffp_summed_new(&capture->patterns[2].image);
    view->images = ffp_alloc(3, sizeof *view->images);
    for (int p = 0; p < 3; p++) view->images[p] = ffp_image_new(SIDE, SIDE, 3);
    view->coverage = ffp_image_new(SIDE, SIDE, 1);
    for (int i = 0; i < SIDE * SIDE; i++) {
        real point[3], u, v, light[3] = {0};
        if (!meet(rig, &view->camera, i % SIDE, i / SIDE, point)) continue;
        view->coverage.data[i] = 1;
        const bool lit = ffp_project(&view->projector, point, &u, &v) > 0 && u >= 0 && v >= 0 &&
                         u < PATTERN && v < PATTERN;
        if (lit) ffp_lookup(&pattern, u, v, 1, 1, light);
        for (int c = 0; c < 3; c++) {
            view->images[0].data[3 * i + c] = 0.03F;
            view->images[1].data[3 * i + c] = 0.03F + (lit ? 0.4F : 0);
            view->images[2].data[3 * i + c] = 0.03F + 0.4F * light[c];
        }
    }
    ffp_summed_free(&pattern);
}

static FfpCapture simulate(const Rig *rig) {
    FfpCapture capture = {.n_patterns = 3, .n_views = rig->views, .black = 0, .white = 1};
    capture.patterns = ffp_alloc(3, sizeof *capture.patterns);
    capture.patterns[2].image = squares();
    capture.views = ffp_alloc((size_t)rig->views, sizeof *capture.views);
    for (int v = 0; v < rig->views; v++) {
        FfpView *view = &capture.views[v];
        view->camera = device(SIDE, 180, 0.2F * (real)v, 0, 0);
        view->projector = device(PATTERN, 330, rig->baseline, rig->toe_in, rig->shift);
        photograph(rig, &capture, view);
    }
    ffp_capture_estimate_bounds(&capture);
    return capture;
}

static void near_parallel_rigs(void **state) {
    (void)state;
    static const Rig rigs[] = {
        {.distance = 5, .radius = 1, .baseline = 1, .toe_in = 0, .views = 1},     // parallel
        {.distance = 5, .radius = 1, .baseline = 1, .toe_in = 0.05F, .views = 1}, // meet four times as far
        {.distance = 5, .radius = 1, .baseline = 1, .toe_in = 0.35F, .views = 1}, // half as far
        {.distance = 4, .radius = 0.8F, .baseline = 1, .toe_in = 0.1F, .shift = 0.4F, .views = 1},
        {.distance = 12, .radius = 2, .baseline = 1.5F, .toe_in = -0.02F, .views = 1}, // diverge
        {.distance = 5, .radius = 1, .baseline = 1, .toe_in = 0.05F, .views = 3},
        {.distance = 6, .radius = 0, .baseline = 1, .toe_in = 0, .views = 1}, // all of the picture is lit
    };
    for (size_t i = 0; i < sizeof rigs / sizeof *rigs; i++) {
        FfpCapture capture = simulate(&rigs[i]);
        const real depth = capture.centre[2], front = rigs[i].distance - 0.6F * rigs[i].radius;
        printf("rig %zu: %.2f, lit surfaces about %.2f; radius %.2f\n", i, (double)depth, (double)front,
               (double)capture.radius);
        assert_true(fabs(depth / front - 1) < 0.1F);
        if (rigs[i].radius > 0)
            assert_true(capture.radius > 0.8F * rigs[i].radius && capture.radius < 1.4F * rigs[i].radius);
        ffp_capture_free(&capture);
    }
}

// A pattern file that is not the one that was shown tells nothing: then the axes do.
static void other_patterns_tell_nothing(void **state) {
    (void)state;
    const Rig rig = {.distance = 5, .radius = 1, .baseline = 1, .toe_in = 0.25F, .views = 1};
    FfpCapture capture = simulate(&rig);
    FfpRng rng = ffp_rng(1, 1);
    for (int i = 0; i < PATTERN * PATTERN * 3; i++) capture.patterns[2].image.data[i] = ffp_rng_uniform(&rng);
    ffp_capture_estimate_bounds(&capture);
    printf("of another pattern: %.2f\n", (double)capture.centre[2]);
    assert_true(fabs(capture.centre[2] / (1 / tan((real)0.25)) - 1) < 0.05F); // where the axes pass
    ffp_capture_free(&capture);
}

// Columns or rows of a Gray code, a pattern and its inverse in turn, as procam-calibration shows them.
static void write_gray_code(int number, const char *path) {
    FfpImage image = ffp_image_new(1024, 768, 3);
    for (int i = 0; i < image.width * image.height * 3; i++) {
        const int at = number < 20 ? i / 3 % image.width : i / 3 / image.width, bit = 9 - number % 20 / 2;
        image.data[i] = (real)(((at ^ at >> 1) >> bit & 1) ^ (number & 1));
    }
    assert_true(ffp_image_write_png(&image, path, NULL));
    ffp_image_free(&image);
}

// The board of a calibration, photographed under three patterns; false when it is not here.
static bool import_board(const char *calibration_name, const char *name, const int shown[3],
                         FfpCapture *capture) {
    static const char *const names[5] = {"black", "white", "first", "second", "third"};
    char sample[1024], calibration[1100], files[5][1100], patterns[3][128], folder[128];
    const char *calibrations[1] = {calibration};
    FfpImportImages images[5];
    FfpImportPattern projected[3];
    if (!shared_path(sample, "real/kamino410/sample")) return false;
    snprintf(calibration, sizeof calibration, "%s/%s", sample, calibration_name);
    for (int i = 0; i < 5; i++) {
        const int number = i < 2 ? 41 - i : shown[i - 2];
        snprintf(files[i], sizeof files[i], "%s/capture_0/graycode_%02d.jpg", sample, number);
        images[i] = (FfpImportImages){.patterns = &names[i], .n_patterns = 1, .files = files[i]};
        if (i < 2) continue;
        snprintf(patterns[i - 2], sizeof patterns[0], "%s/gray_%02d.png", scratch, number);
        write_gray_code(number, patterns[i - 2]);
        projected[i - 2] = (FfpImportPattern){.name = names[i], .file = patterns[i - 2]};
    }
    snprintf(folder, sizeof folder, "%s/%s", scratch, name);
    const FfpImport settings = {.size = sizeof settings,
                                .calibrations = calibrations,
                                .n_calibrations = 1,
                                .images = images,
                                .n_images = 5,
                                .patterns = projected,
                                .n_patterns = 3,
                                .masks = FFP_MASKS_FROM_LIGHT,
                                .projector = {.width = 1024, .height = 768},
                                .width = 320,
                                .folder = folder};
    FfpError err = {0};
    if (!ffp_import(&settings, &err) || !ffp_capture_read(capture, folder, &err)) fail_msg("%s", err.text);
    return true;
}

// The board is 3.64 m away; where the axes pass each other is half a metre before the camera.
static void real_chessboard(void **state) {
    (void)state;
    static const int shown[3] = {12, 24, 28};
    FfpCapture capture;
    if (!import_board("opencv_reference.xml", "board", shown, &capture)) skip();
    printf("board: %.0f mm\n", (double)capture.centre[2]);
    assert_true(fabs(capture.centre[2] / 3643 - 1) < 0.1F);
    ffp_capture_free(&capture);
}

// The repository's own calibration counts the projector's pixels twice.
static void real_projector_counted_twice(void **state) {
    (void)state;
    static const int shown[3] = {12, 16, 24};
    FfpFindings found = {0};
    FfpCapture capture;
    if (!import_board("../calibration_result.xml", "twice", shown, &capture)) skip();
    ffp_rig_checks(&found, &capture, &capture.views[0].camera);
    const FfpFinding *fault = ffp_findings_fault(&found);
    assert_true(fault && strcmp(fault->code, ffp_rule(FFP_RULE_PROJECTOR_SIZE)->code) == 0);
    assert_non_null(strstr(fault->advice, "2048 x 1536"));
    ffp_findings_free(&found);
    ffp_capture_free(&capture);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(near_parallel_rigs),
        cmocka_unit_test(other_patterns_tell_nothing),
        cmocka_unit_test(real_chessboard),
        cmocka_unit_test(real_projector_counted_twice),
    };
    return cmocka_run_group_tests(tests, scratch_setup, scratch_teardown);
}
