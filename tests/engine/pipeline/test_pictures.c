// Pictures as files hold them, and devices that go round.
#include <math.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "engine/pipeline/elsewhere.h"
#include "engine/pipeline/orbit.h"
#include "engine/pipeline/picture_job.h"
#include "engine/pipeline/relight.h"
#include "support.h"

static void test_quantised_values_are_those_of_a_byte(void **state) {
    (void)state;
    FfpImage image = ffp_image_new(7, 1, 1);
    const real values[] = {-1, 0, 0.5F / 255 - 1e-5F, 0.5F / 255 + 1e-5F, 0.7004F, 1, 3};
    const int expected[] = {0, 0, 0, 1, 179, 255, 255};
    memcpy(image.data, values, sizeof values);
    ffp_quantise(&image);
    for (int i = 0; i < 7; i++) assert_float_equal(image.data[i] * 255, expected[i], 1e-3);
    ffp_image_free(&image);
}

static double distance(const FfpCamera *device, const real centre[3]) {
    double sum = 0;
    for (int k = 0; k < 3; k++) {
        const double along = (double)(device->pose[4 * k + 3] - centre[k]);
        sum += along * along;
    }
    return sqrt(sum);
}

static FfpCamera device_at(real x, real y, real z) {
    // looks along the world's y, its picture's up the world's z
    return (FfpCamera){
        .width = 8, .height = 8, .fx = 8, .fy = 8, .pose = {1, 0, 0, x, 0, 0, 1, y, 0, -1, 0, z, 0, 0, 0, 1}};
}

static void test_an_orbit_goes_once_round_the_centre(void **state) {
    (void)state;
    FfpView view = {.camera = device_at(1, -3, 0.5F), .projector = device_at(1.5F, -3, 0.5F)};
    FfpCapture capture = {.n_views = 1, .views = &view, .centre = {1, 0, 0}};
    FfpView *views = ffp_orbit_views(&capture, &view, FFP_ORBIT_CAMERA, 4);
    for (int f = 0; f < 4; f++) {
        const FfpCamera *camera = &views[f].camera;
        assert_float_equal(distance(camera, capture.centre), distance(&view.camera, capture.centre), 1e-5);
        assert_float_equal(camera->pose[11], 0.5, 1e-6);
        assert_memory_equal(views[f].projector.pose, view.projector.pose, sizeof view.projector.pose);
    }
    assert_float_equal(views[0].camera.pose[7], -3, 1e-6);
    assert_float_equal(views[1].camera.pose[3], 4, 1e-5); // a quarter of the way, right-handed about z
    assert_float_equal(views[2].camera.pose[7], 3, 1e-5); // and looks back from the other side
    assert_float_equal(views[2].camera.pose[6], -1, 1e-5);
    ffp_free(views);
}

static char said[512];

static void keep_text(void *user, FfpLogLevel level, const char *text) {
    (void)user, (void)level;
    snprintf(said, sizeof said, "%s", text);
}

typedef struct Placed {
    FfpGaussians gaussians;
    FfpCapture capture;
} Placed;

static bool note(void *argument, FfpError *err) {
    const Placed *placed = argument;
    (void)err;
    ffp_note_elsewhere(&placed->gaussians, &placed->capture);
    return true;
}

static void test_gaussians_of_another_place_are_noted(void **state) {
    (void)state;
    real centre[9] = {5, 0, 0, 5.2F, 0, 0, 0, 0, 0}, opacity[3] = {1, 1, 1};
    FfpContext context = {.settings = {.log = keep_text}};
    Placed placed = {.gaussians = {.count = 3, .centre = centre, .opacity = opacity},
                     .capture = {.name = "cow", .centre = {5, 0, 0}, .radius = 1}};
    assert_true(ffp_call_run(&context, note, &placed, NULL)); // one of three is elsewhere
    assert_string_equal(said, "");
    placed.capture.centre[0] = 0;
    placed.capture.scene = true;
    assert_true(ffp_call_run(&context, note, &placed, NULL));
    assert_string_equal(said, "");
    placed.capture.scene = false;
    assert_true(ffp_call_run(&context, note, &placed, NULL));
    assert_non_null(strstr(said, "67 % of the Gaussians lie outside the sphere of cow"));
}

// A picture from a file becomes as soft as the capture says its projector is; the capture's own stays.
static void test_patterns_are_as_soft_as_the_projector(void **state) {
    (void)state;
    FfpError err = {0};
    FfpPattern own = {.name = "own", .image = ffp_image_new(16, 16, 3)};
    for (int i = 0; i < 16 * 16 * 3; i++) own.image.data[i] = i / 3 % 16 < 8;
    FfpImage encoded = ffp_image_copy(&own.image);
    assert_true(ffp_image_write_png(&encoded, "test_pictures.png", &err));
    FfpView view = {.camera = device_at(1, -3, 0.5F), .projector = device_at(1.5F, -3, 0.5F)};
    view.projector.width = view.projector.height = 16;
    FfpCapture capture = {.n_views = 1, .views = &view, .n_patterns = 1, .patterns = &own, .radius = 1};
    capture.panel.blur = 1;
    const char *const names[] = {"own", "test_pictures.png"};
    const FfpPictures how = {.patterns = names, .n_patterns = 2};
    const FfpGaussians none = {0};
    FfpPictureJob job;
    if (!ffp_picture_job_new(&job, &none, &capture, &how, &err)) fail_msg("%s", err.text);
    const real *sharp = job.patterns[0].image.data + 3 * (16 * 8),
               *soft = job.patterns[1].image.data + 3 * (16 * 8);
    assert_true(sharp[3 * 7] == 1 && sharp[3 * 8] == 0);
    assert_float_equal(soft[3 * 7], 0.6995, 2e-3); // half a pixel within the edge of a step of deviation 1
    assert_float_equal(soft[3 * 8], 0.3005, 2e-3);
    ffp_picture_job_free(&job);
    ffp_image_free(&encoded), ffp_image_free(&own.image);
    remove("test_pictures.png");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_quantised_values_are_those_of_a_byte),
        cmocka_unit_test(test_an_orbit_goes_once_round_the_centre),
        cmocka_unit_test(test_gaussians_of_another_place_are_noted),
        cmocka_unit_test(test_patterns_are_as_soft_as_the_projector),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
