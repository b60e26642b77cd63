// Poses made wrong view by view, and focal lengths, found again from surfaces and the pattern.
#include <math.h>
#include "core/base/alloc.h"
#include "core/base/rigid.h"
#include "core/base/rng.h"
#include "engine/align/align.h"
#include "engine/align/bundle.h"
#include "support.h"

#define DEGREE 0.017453292519943295

static FfpCapture capture;     // normalised
static FfpView *truth, *given; // [n_views]
static size_t size;
static int active;
static FfpError err;

static int setup(void **state) {
    (void)state;
    if (!ffp_capture_read(&capture, FFP_SOURCE_DIR "/data/sample", NULL)) return 1;
    ffp_capture_normalise(&capture, capture.centre, capture.radius);
    active = ffp_capture_active_pattern(&capture, NULL, NULL);
    size = (size_t)capture.n_views * sizeof *truth;
    truth = ffp_alloc(1, size), given = ffp_alloc(1, size);
    memcpy(truth, capture.views, size);
    return 0;
}

static int make_right(void **state) {
    (void)state;
    memcpy(capture.views, truth, size);
    return 0;
}

static int teardown(void **state) {
    make_right(state);
    ffp_capture_free(&capture);
    ffp_free(truth), ffp_free(given);
    return 0;
}

// Each device by itself.
static void make_wrong(double degrees, double shift, uint64_t seed) {
    FfpRng rng = ffp_rng(seed, 1);
    for (int d = 0; d < 2 * capture.n_views; d++) {
        FfpView *view = &capture.views[d / 2];
        FfpCamera *device = d % 2 ? &view->projector : &view->camera;
        FfpRigid motion = ffp_rigid_from_pose(device->pose);
        double v[3], r[9], turned[9];
        for (int k = 0; k < 3; k++) v[k] = degrees * DEGREE * (double)ffp_rng_normal(&rng);
        for (int k = 0; k < 3; k++) motion.t[k] += shift * (double)ffp_rng_normal(&rng);
        ffp_rotation_from_vector(v, r);
        ffp_rotation_product(motion.r, r, turned);
        memcpy(motion.r, turned, sizeof turned);
        ffp_rigid_store(&motion, device->pose);
    }
    memcpy(given, capture.views, size);
}

// Pixels by which view b's camera sees points of the object elsewhere relative to view a's, than in truth:
// what moves everything together does not count.
static double spread_of_points(void) {
    double square = 0, count = 0;
    for (int a = 0; a < capture.n_views; a++)
        for (int b = 0; b < capture.n_views; b++)
            for (int k = 0; k < 6; k++) {
                real point[3] = {0}, local[3], world[3], x[2], y[2];
                point[k / 2] = k % 2 ? 0.6F : -0.6F;
                const real *from = truth[a].camera.pose, *now = capture.views[a].camera.pose;
                for (int i = 0; i < 3; i++) {
                    local[i] = 0;
                    for (int j = 0; j < 3; j++) local[i] += from[4 * j + i] * (point[j] - from[4 * j + 3]);
                }
                for (int i = 0; i < 3; i++)
                    world[i] = now[4 * i] * local[0] + now[4 * i + 1] * local[1] + now[4 * i + 2] * local[2] +
                               now[4 * i + 3];
                ffp_project(&truth[b].camera, point, &x[0], &y[0]);
                ffp_project(&capture.views[b].camera, world, &x[1], &y[1]);
                square += pow((double)(x[1] - x[0]), 2) + pow((double)(y[1] - y[0]), 2), count++;
            }
    return sqrt(square / count);
}

static void adjust(int steps, double focal, FfpBundleReport *first, FfpBundleReport *last) {
    const FfpPoseErrors expected = ffp_align_defaults().expected;
    for (int step = 0; step < steps; step++) {
        if (!ffp_bundle_step(&capture, given, active, &expected, focal, last, &err)) fail_msg("%s", err.text);
        if (step == 0) *first = *last;
    }
}

static void test_each_view(void **state) {
    (void)state;
    FfpBundleReport first, last;
    make_wrong(0.2, 0.003, 5);
    const double before = spread_of_points();
    adjust(5, 0, &first, &last);
    const double after = spread_of_points();
    printf("views apart by %.3f -> %.3f pixels; rays pass the pattern by %.3f -> %.3f, surfaces lie apart by "
           "%.3f -> "
           "%.3f\n",
           before, after, first.off, last.off, first.apart, last.apart);
    assert_true(last.off < 0.5 * first.off && last.apart < 0.8 * first.apart);
    assert_true(after < 0.6 * before);
}

// Right poses stay nearly where they are.
static void test_right_poses(void **state) {
    (void)state;
    SAME_WAY_AGAIN(); // test_each_view
    FfpBundleReport first, last;
    make_wrong(0, 0, 1);
    adjust(3, 0, &first, &last);
    const double after = spread_of_points();
    printf("right poses moved by %.3f pixels\n", after);
    assert_true(after < 0.25);
}

static void test_focal_lengths(void **state) {
    (void)state;
    FfpBundleReport first, last;
    for (int v = 0; v < capture.n_views; v++) {
        capture.views[v].camera.fx *= 1.01F, capture.views[v].camera.fy *= 1.01F;
        capture.views[v].projector.fx *= 0.993F, capture.views[v].projector.fy *= 0.993F;
    }
    make_wrong(0, 0, 1);
    adjust(6, 0.01, &first, &last);
    printf("focal lengths times %.4f and %.4f, rays pass the pattern by %.3f -> %.3f\n", last.camera,
           last.projector, first.off, last.off);
    assert_true(fabs(last.camera * 1.01 - 1) < 0.005 && fabs(last.projector * 0.993 - 1) < 0.005);
}

static void test_needs_pictures(void **state) {
    (void)state;
    const FfpPoseErrors expected = ffp_align_defaults().expected;
    FfpBundleReport report;
    FfpImage *images = capture.views[2].images;
    const FfpImage kept = images[active];
    memcpy(given, capture.views, size);
    images[active].data = NULL;
    assert_false(ffp_bundle_step(&capture, given, active, &expected, 0, &report, &err));
    images[active] = kept;
    assert_non_null(strstr(err.text, capture.views[2].id));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup(test_each_view, make_right),
        cmocka_unit_test_setup(test_right_poses, make_right),
        cmocka_unit_test_setup(test_focal_lengths, make_right),
        cmocka_unit_test_setup(test_needs_pictures, make_right),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
