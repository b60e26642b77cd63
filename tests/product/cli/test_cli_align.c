// Aligning through the command line only: what it writes, and what it refuses before the work.
#include "core/base/rigid.h"
#include "product/cli/program.h"
#include "product/cli/tiny.h"

#define SIDE 48

static ProgramRun run;

static int group_setup(void **state) {
    if (scratch_setup(state) != 0) return -1;
    char folder[128];
    snprintf(folder, sizeof folder, "%s/tiny", scratch);
    tiny_capture(folder, SIDE);
    return 0;
}

// The capture written is like the given one, but for where devices look.
static void test_a_capture_like_the_given_one(void **state) {
    (void)state;
    char path[128];
    FfpCapture given, aligned;
    assert_int_equal(run_format(&run, "align %s/tiny -o %s/aligned", scratch, scratch), 0);
    assert_non_null(strstr(run.out, "aligned in"));
    assert_non_null(strstr(run.out, "all views"));
    snprintf(path, sizeof path, "%s/tiny", scratch);
    assert_true(ffp_capture_read(&given, path, NULL));
    snprintf(path, sizeof path, "%s/aligned", scratch);
    assert_true(ffp_capture_read(&aligned, path, NULL));
    assert_int_equal(aligned.n_views, given.n_views);
    assert_int_equal(aligned.n_patterns, given.n_patterns);
    for (int v = 0; v < given.n_views; v++) {
        const FfpView *a = &given.views[v], *b = &aligned.views[v];
        assert_string_equal(a->id, b->id);
        for (int k = 0; k < 3; k++) {
            assert_true(fabsf(a->camera.pose[4 * k + 3] - b->camera.pose[4 * k + 3]) < 1e-3F);
            assert_true(fabsf(a->camera.pose[4 * k + 2] - b->camera.pose[4 * k + 2]) < 0.02F);
        }
        for (int p = 0; p < given.n_patterns; p++)
            for (int i = 0; i < 3 * SIDE * SIDE; i++)
                assert_true(fabsf(a->images[p].data[i] - b->images[p].data[i]) < 0.02F);
    }
    ffp_capture_free(&given);
    ffp_capture_free(&aligned);
    assert_int_equal(
        run_format(&run, "reconstruct %s/aligned -o %s/a.ply --model none --polish 0", scratch, scratch), 0);
}

// The figures for other programs, from what the views share and from known Gaussians.
static void test_figures_as_json(void **state) {
    (void)state;
    assert_int_equal(run_format(&run, "align %s/tiny -o %s/shared --json", scratch, scratch), 0);
    json_t *told = json_loads(run.out, 0, NULL);
    assert_true(json_is_number(json_object_get(told, "across")) && !json_object_get(told, "camera"));
    json_decref(told);
    assert_int_equal(
        run_format(&run, "align %s/tiny -g %s/a.ply -o %s/known --json", scratch, scratch, scratch), 0);
    told = json_loads(run.out, 0, NULL);
    assert_true(json_number_value(json_object_get(told, "after")) <=
                json_number_value(json_object_get(told, "before")));
    assert_true(json_is_number(json_object_get(json_object_get(told, "projector"), "pixels")));
    json_decref(told);
}

static double ratio_of(const FfpView *view) {
    return (double)view->camera.fx / (double)view->projector.fx;
}

// The tiny capture as devices calibrated wrongly would have made it.
static void write_wrong_focal_lengths(const char *name, float camera, float projector) {
    FfpCapture capture;
    FfpError err = {0};
    if (!ffp_capture_read(&capture, in_scratch("tiny"), &err)) fail_msg("%s", err.text);
    for (int v = 0; v < capture.n_views; v++) {
        FfpView *view = &capture.views[v];
        view->camera.fx *= camera, view->camera.fy *= camera;
        view->projector.fx *= projector, view->projector.fy *= projector;
    }
    if (!ffp_capture_write(&capture, in_scratch(name), &err)) fail_msg("%s", err.text);
    ffp_capture_free(&capture);
}

// Of wrong focal lengths the camera's to the projector's, which is all that pictures tell, comes back to a
// quarter of its error, alike in all views. Both together only make the object larger or smaller.
static void test_focal_lengths(void **state) {
    (void)state;
    FfpCapture truth, given, aligned;
    double camera, projector;
    write_wrong_focal_lengths("wrong", 1.01F, 0.993F);
    assert_int_equal(run_format(&run, "align %s/wrong -o %s/focal --focal", scratch, scratch), 0);
    printf("%s", run.out);
    assert_true(ffp_capture_read(&truth, in_scratch("tiny"), NULL));
    assert_true(ffp_capture_read(&given, in_scratch("wrong"), NULL));
    assert_true(ffp_capture_read(&aligned, in_scratch("focal"), NULL));
    const char *told = strstr(run.out, "focal  ");
    assert_non_null(told);
    assert_int_equal(sscanf(told, "focal camera focal lengths scaled by %lf, projector focal lengths by %lf",
                            &camera, &projector),
                     2);
    assert_int_equal(aligned.n_views, truth.n_views);
    for (int v = 0; v < truth.n_views; v++) {
        const FfpView *was = &given.views[v], *now = &aligned.views[v];
        const double right = ratio_of(&truth.views[v]);
        assert_true(fabs(ratio_of(was) / right - 1) > 0.016);
        assert_true(fabs(ratio_of(now) / right - 1) < 0.004);
        assert_true(fabs((double)(now->camera.fx / was->camera.fx) - camera) < 1e-4);
        assert_true(fabs((double)(now->camera.fy / was->camera.fy) - camera) < 1e-4);
        assert_true(fabs((double)(now->projector.fx / was->projector.fx) - projector) < 1e-4);
        assert_true(fabs((double)(now->projector.fy / was->projector.fy) - projector) < 1e-4);
    }
    ffp_capture_free(&truth);
    ffp_capture_free(&given);
    ffp_capture_free(&aligned);
}

// Radians between two rotations a^T b, each of a projector as its camera sees it.
static double turn_between(const FfpView *a, const FfpView *b) {
    const FfpRigid devices[4] = {ffp_rigid_from_pose(a->camera.pose), ffp_rigid_from_pose(a->projector.pose),
                                 ffp_rigid_from_pose(b->camera.pose), ffp_rigid_from_pose(b->projector.pose)};
    double first[9], second[9], between[9], vector[3];
    ffp_rotation_difference(devices[0].r, devices[1].r, first);
    ffp_rotation_difference(devices[2].r, devices[3].r, second);
    ffp_rotation_difference(first, second, between);
    ffp_rotation_to_vector(between, vector);
    return sqrt(ffp_dot(vector, vector));
}

// A projector that was bumped is found again by the object as it is known, from one view: to a fifth of the
// bump, as the camera sees it. A ball looks the same from everywhere, so that both devices may go round it.
static void test_a_bumped_projector(void **state) {
    (void)state;
    FfpCapture truth, given, found;
    double after, before;
    const double bump[3] = {0.02, -0.015, 0.01};
    assert_int_equal(run_format(&run, "reconstruct %s/tiny -o %s/ball.ply --polish 20", scratch, scratch), 0);
    assert_true(ffp_capture_read(&truth, in_scratch("tiny"), NULL));
    assert_true(ffp_capture_read(&given, in_scratch("tiny"), NULL));
    double turn[9];
    ffp_rotation_from_vector(bump, turn);
    FfpRigid pose = ffp_rigid_from_pose(given.views[0].projector.pose), turned = pose;
    ffp_rotation_product(pose.r, turn, turned.r);
    ffp_rigid_store(&turned, given.views[0].projector.pose);
    const int views = given.n_views;
    given.n_views = 1; // the others are not needed
    assert_true(ffp_capture_write(&given, in_scratch("bumped"), NULL));
    given.n_views = views;
    assert_int_equal(
        run_format(&run, "align %s/bumped -g %s/ball.ply -o %s/found", scratch, scratch, scratch), 0);
    printf("%s", run.out);
    const char *told = strstr(run.out, "values differ by ");
    assert_non_null(told);
    assert_int_equal(sscanf(told, "values differ by %lf (%lf before)", &after, &before), 2);
    assert_true(after < before / 2);
    assert_true(ffp_capture_read(&found, in_scratch("found"), NULL));
    const double off = turn_between(&truth.views[0], &given.views[0]),
                 left = turn_between(&truth.views[0], &found.views[0]);
    printf("off by %.3f degrees, then by %.3f\n", 180 / FFP_PI_DOUBLE * off, 180 / FFP_PI_DOUBLE * left);
    assert_true(off > 0.025 && left < off / 5);
    ffp_capture_free(&truth);
    ffp_capture_free(&given);
    ffp_capture_free(&found);
    assert_int_equal(
        run_format(&run, "align %s/bumped -g %s/ball.ply -o %s/new --focal", scratch, scratch, scratch), 2);
    assert_int_equal(run_format(&run, "align %s/bumped -g %s/none.ply -o %s/new", scratch, scratch, scratch),
                     1);
    assert_non_null(strstr(run.err, "none.ply"));
}

// --- A second projector. ---

// The panel's pixel that lights what a camera's pixel sees of the ball, 0 where none does.
static void code_at(const FfpCamera *camera, const FfpCamera *projector, int pixel, real code[3]) {
    real direction[3], point[3], b = 0, c = -TINY_BALL * TINY_BALL, towards = 0;
    ffp_pixel_ray(camera, (real)(pixel % SIDE) + 0.5F, (real)(pixel / SIDE) + 0.5F, direction);
    memset(code, 0, 3 * sizeof *code);
    for (int i = 0; i < 3; i++)
        b += camera->pose[4 * i + 3] * direction[i], c += camera->pose[4 * i + 3] * camera->pose[4 * i + 3];
    if (b * b < c) return;
    for (int i = 0; i < 3; i++) {
        point[i] = camera->pose[4 * i + 3] + (-b - sqrtf(b * b - c)) * direction[i];
        towards += (projector->pose[4 * i + 3] - point[i]) * point[i];
    }
    if (towards <= 0) return;
    code[2] = ffp_project(projector, point, &code[0], &code[1]) > 0;
}

// The tiny capture's second projector, which turns with its camera as all devices do around the ball.
static FfpCamera second_projector(int view) {
    const float turn = (float)view * 6.2831853F / TINY_VIEWS, c = cosf(turn), s = sinf(turn),
                at[3] = {1.9F * c + 1.2F * s, 1.9F * s - 1.2F * c, 0.7F};
    FfpCamera projector = tiny_device(at, TINY_PATTERN, TINY_PATTERN * 1.15F);
    projector.cy += 3;
    return projector;
}

// A view under its light, of which the file says nothing right; at most so many pixels have codes, 0: it has
// no Gray codes.
static void light_view(FfpCapture *capture, int v, int codes) {
    FfpView *view = &capture->views[v];
    const FfpCamera projector = second_projector(v);
    for (int p = 0; p < capture->n_patterns; p++) {
        FfpSummed light = ffp_summed_new(&capture->patterns[p].image);
        FfpImage picture = tiny_photograph(&view->camera, &projector, &light);
        for (int i = 0; i < SIDE * SIDE * 3; i++)
            view->images[p].data[i] = picture.data[i / 3 * 4 + i % 3] * picture.data[i / 3 * 4 + 3];
        ffp_image_free(&picture);
        ffp_summed_free(&light);
    }
    if (codes > 0) view->correspondence = ffp_image_new(SIDE, SIDE, 3);
    for (int i = 0; i < SIDE * SIDE && codes > 0; i++) {
        real *code = view->correspondence.data + 3 * i;
        code_at(&view->camera, &projector, i, code);
        codes -= code[2] > 0;
    }
}

// The first of its views, so lit.
static void write_second(const char *name, int n_views, int codes) {
    FfpCapture capture;
    FfpError err = {0};
    if (!ffp_capture_read(&capture, in_scratch("tiny"), &err)) fail_msg("%s", err.text);
    for (int v = 0; v < n_views; v++) light_view(&capture, v, codes);
    const int views = capture.n_views;
    capture.n_views = n_views;
    capture.intensity_known = false;
    if (!ffp_capture_write(&capture, in_scratch(name), &err)) fail_msg("%s", err.text);
    capture.n_views = views;
    ffp_capture_free(&capture);
}

// A projector's place to `most`, and its direction and lens by as much.
static void is_found(const FfpCapture *capture, int v, float most) {
    const FfpCamera *projector = &capture->views[v].projector, right = second_projector(v);
    printf("at %.3f %.3f %.3f of %.3f %.3f %.3f, focal length %.2f of %.2f, middle %.2f %.2f of %.2f %.2f\n",
           (double)projector->pose[3], (double)projector->pose[7], (double)projector->pose[11],
           (double)right.pose[3], (double)right.pose[7], (double)right.pose[11], (double)projector->fx,
           (double)right.fx, (double)projector->cx, (double)projector->cy, (double)right.cx,
           (double)right.cy);
    for (int k = 0; k < 3; k++) {
        assert_float_equal(projector->pose[4 * k + 3], right.pose[4 * k + 3], most);
        assert_float_equal(projector->pose[4 * k + 2], right.pose[4 * k + 2], most / 4);
    }
    assert_float_equal(projector->fx / right.fx, 1, most / 2);
    assert_float_equal(projector->cy / right.height, right.cy / right.height, most / 4);
}

// Found where it stands, with its lens and its light; commands take the capture as one of its own.
static void test_a_second_projector(void **state) {
    (void)state;
    FfpCapture found;
    write_second("lit", 1, SIDE * SIDE);
    assert_int_equal(run_format(&run, "align %s/lit -g %s/ball.ply --second-projector --json -o %s/second",
                                scratch, scratch, scratch),
                     0);
    json_t *told = json_loads(run.out, 0, NULL),
           *pose = json_object_get(json_object_get(told, "projector"), "pose");
    assert_int_equal(json_array_size(pose), 16);
    assert_true(json_number_value(json_object_get(told, "rms")) < 0.5);
    assert_true(ffp_capture_read(&found, in_scratch("second"), NULL));
    is_found(&found, 0, 0.2F);
    for (int k = 0; k < 3; k++) {
        assert_float_equal(json_number_value(json_array_get(pose, (size_t)(4 * k + 3))),
                           found.views[0].projector.pose[4 * k + 3], 1e-4);
        assert_float_equal(found.intensity[k], 4, 0.5);
    }
    json_decref(told);
    ffp_capture_free(&found);
    assert_int_equal(
        run_format(&run, "map %s/ball.ply --capture %s/second -o %s/maps", scratch, scratch, scratch), 0);
    assert_int_equal(
        run_format(&run,
                   "compensate %s/ball.ply -c %s/second -v view_0 -t %s/second/patterns/stripes.png "
                   "-o %s/sent.png --paint --steps 2",
                   scratch, scratch, scratch, scratch),
        0);
}

// From all sides at once, and told in words.
static void test_a_second_projector_at_every_stop(void **state) {
    (void)state;
    FfpCapture found;
    write_second("around", TINY_VIEWS, SIDE * SIDE);
    assert_int_equal(run_format(&run, "align %s/around -g %s/ball.ply --second-projector -o %s/turned",
                                scratch, scratch, scratch),
                     0);
    printf("%s", run.out);
    assert_non_null(strstr(run.out, "points used"));
    assert_true(ffp_capture_read(&found, in_scratch("turned"), NULL));
    for (int v = 0; v < TINY_VIEWS; v++) is_found(&found, v, 0.15F);
    ffp_capture_free(&found);
}

static void test_no_second_projector(void **state) {
    (void)state;
    static const char command[] = "align %s/%s -g %s/ball.ply --second-projector -o %s/none";
    write_second("plain", 1, 0);
    assert_int_equal(run_format(&run, command, scratch, "plain", scratch, scratch), 1);
    assert_non_null(strstr(run.err, "no view has Gray codes"));
    write_second("few", 1, 50);
    assert_int_equal(run_format(&run, command, scratch, "few", scratch, scratch), 1);
    assert_non_null(strstr(run.err, "are the least"));
    assert_false(ffp_is_file(in_scratch("none/scene.json")));
    assert_int_equal(run_format(&run, "align %s/plain --second-projector -o %s/none", scratch, scratch), 2);
    assert_int_equal(run_format(&run, "import -c x.xml -i black=x.png --other-projector -o %s/none", scratch),
                     2);
    assert_non_null(strstr(run.err, "--projector-size"));
}

static void test_refusals_come_before_the_work(void **state) {
    (void)state;
    assert_int_equal(run_format(&run, "align %s/tiny -o %s/tiny", scratch, scratch), 1);
    assert_non_null(strstr(run.err, "not empty"));
    assert_null(strstr(run.err, "aligning"));
    assert_int_equal(run_format(&run, "align %s/nothing -o %s/new", scratch, scratch), 1);
    assert_non_null(strstr(run.err, "nothing"));
    assert_false(ffp_is_file(in_scratch("new/scene.json")));
    assert_int_equal(run_format(&run, "align %s/tiny -o %s/new --pattern plaid", scratch, scratch), 1);
    assert_non_null(strstr(run.err, "plaid"));
    assert_int_equal(access(in_scratch("new"), F_OK), -1);
    assert_int_equal(run_format(&run, "align %s/tiny", scratch), 2);
    assert_int_equal(run_format(&run, "align -o %s/new", scratch), 2);
    assert_int_equal(run_format(&run, "align --help"), 0);
    assert_non_null(strstr(run.out, "example"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_capture_like_the_given_one),
        cmocka_unit_test(test_figures_as_json),
        cmocka_unit_test(test_focal_lengths),
        cmocka_unit_test(test_a_bumped_projector),
        cmocka_unit_test(test_a_second_projector),
        cmocka_unit_test(test_a_second_projector_at_every_stop),
        cmocka_unit_test(test_no_second_projector),
        cmocka_unit_test(test_refusals_come_before_the_work),
    };
    return cmocka_run_group_tests(tests, group_setup, scratch_teardown);
}
