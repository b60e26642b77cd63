// Whole scenes: where the devices stand, and what the cameras see.
#include <math.h>
#include <string.h>
#include "support.h"
#include "world/synth/scene.h"
#include "world/synth/walk.h"

static FfpSceneSpec walk_spec(uint64_t seed) {
    FfpSceneSpec spec = ffp_scene_defaults();
    spec.mesh = 17, spec.material = 5, spec.seed = seed;
    spec.rig = FFP_SCENE_WALK, spec.resolution = 32, spec.targets = 2;
    spec.lollipops = 1, spec.pattern_side = 120;
    return spec;
}

static void every_kind_of_scene_is_drawn(void **state) {
    (void)state;
    const char *seen[FFP_WALK_KINDS];
    int count = 0;
    for (uint64_t seed = 0; seed < 40; seed++) {
        const FfpSceneSpec spec = walk_spec(seed);
        const char *name = ffp_walk_name(&spec);
        bool known = false;
        for (int i = 0; i < count; i++) known |= strcmp(seen[i], name) == 0;
        if (known) continue;
        seen[count++] = name;
        FfpWalk walk = ffp_walk_draw(&spec);
        assert_true(walk.room.n_parts >= 4 && walk.room.n_parts <= FFP_ROOM_PARTS);
        ffp_walk_free(&walk);
    }
    assert_int_equal(count, FFP_WALK_KINDS);
}

static double azimuth(const FfpCamera *camera) {
    return atan2((double)camera->pose[7], (double)camera->pose[3]) * 57.29577951308232;
}

// One projector for all views; the camera goes from one end of its arc to the other.
static void the_camera_walks_and_the_projector_stands(void **state) {
    (void)state;
    const FfpSceneSpec spec = walk_spec(3);
    FfpWalk walk = ffp_walk_draw(&spec);
    FfpView first = {0};
    double before = -INFINITY;
    ffp_walk_input(&walk, &spec, 0, &first);
    for (int i = 0; i < spec.views; i++) {
        FfpView view = {0};
        ffp_walk_input(&walk, &spec, i, &view);
        assert_memory_equal(&view.projector, &first.projector, sizeof view.projector);
        assert_int_equal(view.camera.width, 48);
        assert_true(azimuth(&view.camera) > before + 5);
        before = azimuth(&view.camera);
    }
    assert_true(before - azimuth(&first.camera) > 70 && before - azimuth(&first.camera) < 90);
    ffp_walk_free(&walk);
}

static void two_projectors_take_turns(void **state) {
    (void)state;
    FfpSceneSpec spec = walk_spec(3);
    spec.rig = FFP_SCENE_WALK_TWO;
    FfpWalk walk = ffp_walk_draw(&spec);
    FfpView view[3] = {{.id = ""}};
    assert_int_equal(walk.n_projectors, 2);
    for (int i = 0; i < 3; i++) ffp_walk_input(&walk, &spec, i, &view[i]);
    assert_true(ffp_same_device(&view[0].camera, &view[1].camera));
    assert_false(ffp_same_device(&view[0].projector, &view[1].projector));
    assert_false(ffp_same_device(&view[0].camera, &view[2].camera));
    assert_true(ffp_same_device(&view[0].projector, &view[2].projector));
    assert_string_equal(view[1].id, "walk_00_b");
    ffp_walk_free(&walk);
}

// Everything in view belongs to the scene, and a part of it, never all, has the projector's light. The light
// is where the truth says, and the far and near ends that are estimated enclose the truth.
static void all_of_a_scene_is_covered_and_part_of_it_is_lit(void **state) {
    (void)state;
    for (uint64_t seed = 0; seed < 3; seed++) {
        const FfpSceneSpec spec = walk_spec(seed);
        FfpCapture capture;
        FfpError err;
        if (!ffp_scene_make(&capture, &spec, &err)) fail_msg("%s", err.text);
        assert_true(capture.scene);
        for (int v = 0; v < capture.n_views; v++) {
            const FfpView *view = &capture.views[v];
            const int pixels = view->camera.width * view->camera.height;
            int lit = 0, outside = 0;
            for (int i = 0; i < pixels; i++) {
                assert_float_equal(view->coverage.data[i], 1, 0);
                lit += view->direct_white.data[3 * i] > 0;
                outside += view->depth.data[i] < view->near || view->depth.data[i] > view->far;
            }
            assert_true(lit > pixels / 8 && lit < 7 * pixels / 8);
            if (outside >= pixels / 20) fail_msg("%d of %d pixels are out of range", outside, pixels);
        }
        ffp_capture_free(&capture);
    }
}

static void a_scene_takes_no_mesh_of_the_users(void **state) {
    (void)state;
    FfpSceneSpec spec = walk_spec(0);
    FfpMesh mesh = {0};
    FfpCapture capture;
    FfpError err;
    spec.own_mesh = &mesh;
    assert_false(ffp_scene_make(&capture, &spec, &err));
    assert_non_null(strstr(err.text, "generated objects"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_kind_of_scene_is_drawn),
        cmocka_unit_test(the_camera_walks_and_the_projector_stands),
        cmocka_unit_test(two_projectors_take_turns),
        cmocka_unit_test(all_of_a_scene_is_covered_and_part_of_it_is_lit),
        cmocka_unit_test(a_scene_takes_no_mesh_of_the_users),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
