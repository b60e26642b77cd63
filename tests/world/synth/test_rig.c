// Free rigs: where the devices stand, what they see, and that nothing but the devices changes.
#include <math.h>
#include "support.h"
#include "world/shapes/mesh.h"
#include "world/synth/rig.h"
#include "world/synth/scene.h"

static const double DEGREE = 3.14159265358979323846 / 180;

static FfpSceneSpec free_spec(int views, uint64_t seed) {
    FfpSceneSpec spec = ffp_scene_defaults();
    spec.mesh = 17, spec.material = 5, spec.seed = seed;
    spec.rig = FFP_SCENE_FREE, spec.views = views;
    return spec;
}

static void position(const FfpCamera *device, double at[3]) {
    for (int k = 0; k < 3; k++) at[k] = (double)device->pose[4 * k + 3];
}

static double angle(const double a[3], const double b[3]) {
    double dot = 0, aa = 0, bb = 0;
    for (int k = 0; k < 3; k++) dot += a[k] * b[k], aa += a[k] * a[k], bb += b[k] * b[k];
    return acos(fmin(1, fmax(-1, dot / sqrt(aa * bb)))) / DEGREE;
}

static void assert_rigid(const FfpCamera *device) {
    for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++) {
            double dot = 0;
            for (int k = 0; k < 3; k++)
                dot += (double)device->pose[4 * k + a] * (double)device->pose[4 * k + b];
            assert_float_equal(dot, a == b, 1e-5);
        }
}

// The sphere of the meshes lies between the sides of the picture: its centre is at least its radius away from
// the four planes through the camera and a side.
static void assert_in_frame(const FfpCamera *camera) {
    double centre[3] = {0, 0, 0};
    for (int k = 0; k < 3; k++)
        for (int m = 0; m < 3; m++)
            centre[k] -= (double)camera->pose[4 * m + k] * (double)camera->pose[4 * m + 3];
    const double slope = 0.5 * camera->width / (double)camera->fx, scale = sqrt(1 + slope * slope);
    for (int k = 0; k < 2; k++)
        assert_true((slope * centre[2] - fabs(centre[k])) / scale > (double)FFP_MESH_RADIUS);
}

static void devices_stand_where_they_should(void **state) {
    (void)state;
    double least_field = 90, most_field = 0;
    int right = 0, count = 0;
    for (uint64_t seed = 0; seed < 40; seed++) {
        const FfpSceneSpec spec = free_spec(1 + (int)seed, seed);
        for (int i = 0; i < spec.views; i++) {
            FfpView view = {0};
            ffp_rig_input(&spec, i, &view);
            double c[3], p[3];
            const double pole[3] = {0, 0, 1};
            position(&view.camera, c), position(&view.projector, p);
            const double away = hypot(hypot(c[0], c[1]), c[2]), thrown = hypot(hypot(p[0], p[1]), p[2]);
            assert_true(away > 2.699 && away < 3.401 && thrown > 1.799 && thrown < 2.401);
            assert_true(angle(c, pole) > 39.9 && angle(c, pole) < 130.1);
            assert_true(angle(c, p) > 14.9 && angle(c, p) < 64);
            const double field = 2 * atan(0.5 * view.camera.width / (double)view.camera.fx) / DEGREE;
            assert_true(field > 33.9 && field < 46.1);
            least_field = fmin(least_field, field), most_field = fmax(most_field, field);
            double across = 0;
            for (int k = 0; k < 3; k++) across += (double)view.camera.pose[4 * k] * p[k];
            right += across > 0, count++;
            assert_rigid(&view.camera), assert_rigid(&view.projector);
            assert_in_frame(&view.camera);
        }
    }
    assert_true(least_field < 36 && most_field > 45);
    assert_true(right > count / 3 && right < 2 * count / 3);
}

// How far the nearest of the views' cameras is from the place of the band that is farthest from all, degrees.
static double widest_gap(const FfpSceneSpec *spec) {
    double at[64][3], widest = 0;
    for (int i = 0; i < spec->views; i++) {
        FfpView view = {0};
        ffp_rig_input(spec, i, &view);
        position(&view.camera, at[i]);
    }
    for (int polar = 40; polar <= 130; polar += 5)
        for (int azimuth = 0; azimuth < 360; azimuth += 5) {
            const double s = sin(polar * DEGREE), c = cos(polar * DEGREE);
            const double place[3] = {s * cos(azimuth * DEGREE), s * sin(azimuth * DEGREE), c};
            double nearest = 180;
            for (int i = 0; i < spec->views; i++) nearest = fmin(nearest, angle(place, at[i]));
            widest = fmax(widest, nearest);
        }
    return widest;
}

// A lattice of triangles would leave 106 degrees / sqrt(views).
static void cameras_are_spread_over_the_band(void **state) {
    (void)state;
    static const int counts[] = {4, 6, 8, 12, 16, 32, 64};
    for (size_t n = 0; n < sizeof counts / sizeof *counts; n++)
        for (uint64_t seed = 0; seed < 10; seed++) {
            const FfpSceneSpec spec = free_spec(counts[n], seed);
            assert_true(widest_gap(&spec) < 200 / sqrt(spec.views));
        }
}

// The sphere rig: one projector for all views, the camera 3 away on a spiral, all of the band and no two of
// 297 places alike.
static void the_sphere_rig_moves_the_camera_alone(void **state) {
    (void)state;
    FfpSceneSpec spec = free_spec(297, 5);
    spec.rig = FFP_SCENE_SPHERE;
    FfpView first = {0};
    double before[3] = {0, 0, 0}, least = 180, most = 0;
    const double pole[3] = {0, 0, 1};
    ffp_rig_input(&spec, 0, &first);
    for (int i = 0; i < spec.views; i++) {
        FfpView view = {0};
        double c[3];
        ffp_rig_input(&spec, i, &view);
        position(&view.camera, c);
        assert_rigid(&view.camera);
        assert_in_frame(&view.camera);
        assert_memory_equal(&view.projector, &first.projector, sizeof view.projector);
        assert_float_equal(hypot(hypot(c[0], c[1]), c[2]), 3, 1e-5);
        if (i) assert_true(angle(c, before) > 1);
        least = fmin(least, angle(c, pole)), most = fmax(most, angle(c, pole));
        memcpy(before, c, sizeof before);
    }
    assert_true(least > 20 && least < 22 && most > 109 && most < 110);
}

// Most of what a camera sees has the projector's light, though never all of it has.
static void the_projector_lights_what_the_camera_sees(void **state) {
    (void)state;
    FfpSceneSpec spec = free_spec(12, 3);
    spec.resolution = 48, spec.targets = 0, spec.lollipops = 1, spec.pattern_side = 200;
    FfpCapture capture;
    FfpError err;
    if (!ffp_scene_make(&capture, &spec, &err)) fail_msg("%s", err.text);
    for (int v = 0; v < capture.n_views; v++) {
        const FfpView *view = &capture.views[v];
        int seen = 0, lit = 0;
        for (int i = 0; i < 48 * 48; i++) {
            seen += view->coverage.data[i] == 1;
            lit += view->coverage.data[i] == 1 && view->direct_white.data[3 * i] > 0;
        }
        assert_true(seen > 100 && lit > seen / 3 && lit < seen);
    }
    ffp_capture_free(&capture);
}

// Another resolution has the same poses and fields of view.
static void resolution_leaves_the_poses(void **state) {
    (void)state;
    for (int kind = 0; kind < 4; kind++) {
        FfpSceneSpec small = free_spec(5, 9);
        small.rig = kind & 1 ? FFP_SCENE_FREE : FFP_SCENE_TURNTABLE, small.jitter = kind & 2;
        FfpSceneSpec large = small;
        large.resolution = 2 * small.resolution;
        for (int i = 0; i < 2 * small.views; i++) {
            FfpView a = {0}, b = {0};
            const int index = i % small.views;
            (i < small.views ? ffp_rig_input : ffp_rig_target)(&small, index, &a);
            (i < small.views ? ffp_rig_input : ffp_rig_target)(&large, index, &b);
            assert_string_equal(a.id, b.id);
            assert_memory_equal(a.camera.pose, b.camera.pose, sizeof a.camera.pose);
            assert_memory_equal(&a.projector, &b.projector, sizeof a.projector);
            assert_float_equal(2 * a.camera.fx, b.camera.fx, 1e-3);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(devices_stand_where_they_should),
        cmocka_unit_test(cameras_are_spread_over_the_band),
        cmocka_unit_test(the_sphere_rig_moves_the_camera_alone),
        cmocka_unit_test(the_projector_lights_what_the_camera_sees),
        cmocka_unit_test(resolution_leaves_the_poses),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
