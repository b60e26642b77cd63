// The page of checks: a good capture passes, and each thing that people get wrong is found under its name.
// Labels: slow
#include <math.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/vec.h"
#include "rig/checks/chord.h"
#include "rig/checks/found.h"
#include "rig/checks/measure.h"
#include "rig/checks/slip.h"

static int check(void) {
    int doubts = 0;
    ffp_findings_free(&found);
    ffp_rig_checks(&found, &capture, &capture.views[0].camera);
    for (int i = 0; i < found.count; i++) doubts += found.items[i].severity > FFP_FINDING_NOTE;
    return doubts;
}

static const FfpFinding *must_doubt(FfpRuleId rule, const char *view) {
    check();
    return must_find(rule, view);
}

static void test_good(void **state) {
    (void)state;
    // Spot's glaze clips under white; nothing else is to be doubted.
    assert_int_equal(check(), 1);
    must_find(FFP_RULE_CLIPPED, NULL);
    assert_true(ffp_rig_silhouette_misfit(&capture) < 0.005);
    const FfpExplanation e = ffp_rig_explain(&capture, ffp_capture_active_pattern(&capture, NULL, NULL));
    assert_true(e.pixels > 1500);
    assert_true(e.error < 0.04 && e.chance > 0.08);
    assert_true(e.best == e.error && e.across == 0);
    assert_true(fabs(e.direction[0] - 1) < 1e-3); // the projector stands above the camera
}

static void test_swapped(void **state) {
    (void)state;
    const int black = capture.black;
    capture.black = capture.white, capture.white = black;
    must_doubt(FFP_RULE_WHITE_DARKER, NULL);
}

// A rotation about z, the turntable's axis, of both devices.
static void turn(FfpView *view, double angle) {
    real *const poses[2] = {view->camera.pose, view->projector.pose};
    for (int k = 0; k < 2; k++)
        for (int j = 0; j < 4; j++) {
            const double x = (double)poses[k][j], y = (double)poses[k][4 + j];
            poses[k][j] = (real)(cos(angle) * x - sin(angle) * y);
            poses[k][4 + j] = (real)(sin(angle) * x + cos(angle) * y);
        }
}

static void test_angles_reversed(void **state) {
    (void)state;
    SAME_WAY_AGAIN();
    for (int v = 0; v < capture.n_views; v++) turn(&capture.views[v], -2 * v * acos(-1.0) / 4);
    must_doubt(FFP_RULE_VIEWS_CONTRADICT, NULL);
}

static void test_axis_moved(void **state) {
    (void)state;
    SAME_WAY_AGAIN();
    for (int v = 0; v < capture.n_views; v++) {
        real *const poses[2] = {capture.views[v].camera.pose, capture.views[v].projector.pose};
        for (int k = 0; k < 2; k++) // both go aside by a tenth of the object, as seen from the camera
            for (int i = 0; i < 3; i++) poses[k][4 * i + 3] += 0.1F * poses[0][4 * i];
    }
    must_doubt(FFP_RULE_VIEWS_CONTRADICT, NULL);
}

static void test_pattern_mirrored(void **state) {
    (void)state;
    FfpImage *image = &capture.patterns[ffp_capture_active_pattern(&capture, NULL, NULL)].image;
    for (int y = 0; y < image->height; y++)
        for (int x = 0; x < image->width / 2; x++)
            for (int c = 0; c < 3; c++) {
                real *a = &image->data[3 * (y * image->width + x) + c];
                real *b = &image->data[3 * (y * image->width + image->width - 1 - x) + c], kept = *a;
                *a = *b, *b = kept;
            }
    assert_non_null(strstr(must_doubt(FFP_RULE_PATTERN_MIRRORED, NULL)->text, "left to right"));
}

// A view whose camera was bumped by two pixels, and one with something in front of it under the pattern.
static void test_one_view(void **state) {
    (void)state;
    const int active = ffp_capture_active_pattern(&capture, NULL, NULL);
    const int shown[3] = {capture.black, capture.white, active};
    FfpView *view = &capture.views[3];
    for (int k = 0; k < 4; k++) {
        FfpImage *image = k < 3 ? &view->images[shown[k]] : &view->coverage;
        const ptrdiff_t step = 2 * (image->width + 1) * image->channels,
                        count = (ptrdiff_t)image->width * image->height * image->channels;
        memmove(image->data + step, image->data, (size_t)(count - step) * sizeof *image->data);
    }
    must_doubt(FFP_RULE_VIEW_MOVED, "path_0_theta135");
    for (int v = 0; v < capture.n_views; v++) { // all others fit worse: it is not the odd one
        FfpImage *other = &capture.views[v].images[active];
        const FfpImage *lit = &capture.views[v].images[capture.white];
        for (int i = 0; i < 3 * other->width * other->height && v != 3; i++)
            other->data[i] = 0.5F * other->data[i] + 0.25F * lit->data[i];
    }
    const FfpExplanation e = ffp_rig_explain(&capture, active);
    assert_true(e.odd != 3);
    teardown(NULL);
    assert_int_equal(setup(NULL), 0);
    FfpImage *seen = &capture.views[2].images[active];
    const FfpImage *white = &capture.views[2].images[capture.white];
    for (int i = 0; i < 3 * seen->width * seen->height / 2; i++) seen->data[i] = 0.7F * white->data[i];
    must_doubt(FFP_RULE_VIEW_SPOILT, "path_0_theta090");
}

// Where the others are too dark to be asked, nobody can say that a view is unlike them.
static void test_one_view_in_the_light(void **state) {
    (void)state;
    const int active = ffp_capture_active_pattern(&capture, NULL, NULL);
    for (int v = 0; v < capture.n_views; v++) {
        FfpView *view = &capture.views[v];
        const int shown[2] = {capture.white, active};
        if (v == 3) view->projector.cx += 20;
        for (int i = 0; i < 3 * view->camera.width * view->camera.height && v != 3; i++)
            for (int k = 0; k < 2; k++) view->images[shown[k]].data[i] = view->images[capture.black].data[i];
    }
    const FfpExplanation e = ffp_rig_explain(&capture, active);
    assert_true(e.pixels > 100);
    assert_int_equal(e.odd, -1);
}

// A sound view of which a few pixels are seen, in one place or another: some shift may fit these by chance,
// but accuses nobody.
static void test_few_pixels(void **state) {
    (void)state;
    SAME_WAY_AGAIN();
    const int active = ffp_capture_active_pattern(&capture, NULL, NULL);
    FfpImage *mask = &capture.views[3].coverage, whole = ffp_image_copy(mask);
    for (int x = 36; x < 60; x += 8) {
        for (int i = 0; i < mask->width * mask->height; i++) {
            const bool in = abs(i % mask->width - x) < 5 && abs(i / mask->width - 52) < 5;
            mask->data[i] = in ? whole.data[i] : 0;
        }
        if (ffp_rig_explain(&capture, active).odd == 3) fail_msg("accused by the pixels around %d, 52", x);
    }
    ffp_image_free(&whole);
}

// One in 28 pixels of a view shows something else, as beside what the sphere holds: its photograph is
// right.
static void test_outliers(void **state) {
    (void)state;
    const int active = ffp_capture_active_pattern(&capture, NULL, NULL);
    const FfpView *view = &capture.views[3];
    for (int i = 0; i < view->camera.width * view->camera.height; i++)
        for (int c = 0; c < 3 && ((unsigned)i * 2654435761U >> 16) % 28 == 0; c++) {
            const real black = view->images[capture.black].data[3 * i + c],
                       white = view->images[capture.white].data[3 * i + c];
            real *seen = &view->images[active].data[3 * i + c];
            *seen = *seen - black > white - *seen ? black : white;
        }
    ffp_findings_free(&found);
    assert_true(ffp_rig_faults(&found, &capture));
}

// The platter turns about z: the object stays where it is put, and the devices go round it.
static void shift(FfpView *view, double x, double y) {
    real *const poses[2] = {view->camera.pose, view->projector.pose};
    for (int k = 0; k < 2; k++) poses[k][3] += (real)x, poses[k][7] += (real)y;
}

static void test_slipped(void **state) {
    (void)state;
    SAME_WAY_AGAIN();
    const int active = ffp_capture_active_pattern(&capture, NULL, NULL);
    const double far = 0.05 * (double)capture.radius;
    for (int v = 4; v < 8; v++) shift(&capture.views[v], 0.6 * far, 0.8 * far);
    assert_string_equal(must_doubt(FFP_RULE_SLIPPED_VIEWS, "path_0_theta180")->other, "path_0_theta315");
    FfpSlip slip = ffp_rig_slip(&capture, active);
    assert_int_equal(slip.compared, 8);
    assert_true(slip.first == 4 && slip.last == 7);
    assert_true(fabs(slip.shift - far) < 0.2 * far);
    for (int v = 4; v < 8; v++) shift(&capture.views[v], -0.6 * far, -0.8 * far);
    turn(&capture.views[2], acos(-1.0) / 15);
    must_doubt(FFP_RULE_SLIPPED, "path_0_theta090");
    turn(&capture.views[2], -acos(-1.0) / 15);
    shift(&capture.views[2], 0, far), shift(&capture.views[4], far, 0);
    must_doubt(FFP_RULE_APART, NULL);
    slip = ffp_rig_slip(&capture, active);
    assert_true(slip.pairs > 2 && slip.pair >= 1 && slip.pair <= 4 && slip.first == -1);
}

// A view through a lens that spreads each point over its neighbours.
static void test_out_of_focus(void **state) {
    (void)state;
    FfpView *view = &capture.views[5];
    const int shown[3] = {capture.black, capture.white, ffp_capture_active_pattern(&capture, NULL, NULL)};
    for (int k = 0; k < 3; k++) ffp_image_blur(&view->images[shown[k]], 1.2F);
    must_doubt(FFP_RULE_BLURRED, "path_0_theta225");
}

// A mask in which a hand is left.
static void test_hand_in_a_mask(void **state) {
    (void)state;
    FfpImage *mask = &capture.views[1].coverage;
    for (int i = 0; i < mask->width * mask->height; i++)
        if (i % mask->width < 30 && i / mask->width > 80) mask->data[i] = 1;
    must_doubt(FFP_RULE_VIEW_CONTRADICTS, "path_0_theta045");
    FfpSilhouettes shapes = ffp_rig_silhouettes(&capture);
    assert_int_equal(shapes.odd, 1);
    assert_true(shapes.own[1] > 0.03);
    ffp_rig_silhouettes_free(&shapes);
}

static void test_projector_off(void **state) {
    (void)state;
    SAME_WAY_AGAIN();
    for (int v = 0; v < capture.n_views; v++) capture.views[v].projector.cx += 20;
    assert_non_null(strstr(must_doubt(FFP_RULE_PATTERN_MOVED, NULL)->advice, " 20, 0 "));
}

static void test_projector_turned_away(void **state) {
    (void)state;
    for (int v = 0; v < capture.n_views; v++)
        for (int i = 0; i < 3; i++) {
            real *row = capture.views[v].projector.pose + 4 * i;
            row[0] = -row[0], row[2] = -row[2];
        }
    must_doubt(FFP_RULE_OBJECT_BEHIND, NULL);
    must_doubt(FFP_RULE_LIT_WHERE_NONE, NULL);
}

// A calibration whose tool counts the projector's pixels otherwise than the pattern's file.
static void test_projector_counted_otherwise(void **state) {
    (void)state;
    SAME_WAY_AGAIN();
    static const real factors[2] = {2, 0.25F}; // twice as many, then half
    static const char *const advice[2] = {"calibrated at 1600 x 1600", "calibrated at 400 x 400"};
    for (int k = 0; k < 2; k++) {
        for (int v = 0; v < capture.n_views; v++) {
            FfpCamera *projector = &capture.views[v].projector;
            projector->fx *= factors[k], projector->fy *= factors[k];
            projector->cx *= factors[k], projector->cy *= factors[k];
        }
        assert_non_null(strstr(must_doubt(FFP_RULE_PROJECTOR_SIZE, NULL)->advice, advice[k]));
    }
}

static void test_unit(void **state) {
    (void)state;
    SAME_WAY_AGAIN();
    capture.radius *= 3;
    must_doubt(FFP_RULE_UNUSUAL, NULL);
}

static void test_upside_down(void **state) {
    (void)state;
    SAME_WAY_AGAIN();
    for (int v = 0; v < capture.n_views; v++)
        for (int i = 0; i < 3; i++) {
            real *row = capture.views[v].camera.pose + 4 * i;
            row[0] = -row[0], row[1] = -row[1];
        }
    must_doubt(FFP_RULE_UNUSUAL + FFP_RULE_ROLL - FFP_RULE_CAMERA_DISTANCE, NULL);
}

static void test_light(void **state) {
    (void)state;
    for (int v = 0; v < capture.n_views; v++) {
        const FfpView *view = &capture.views[v];
        for (int i = 0; i < 3 * view->camera.width * view->camera.height; i++) {
            const real white = view->images[capture.white].data[i];
            view->images[capture.black].data[i] += 0.95F * (white - view->images[capture.black].data[i]);
        }
    }
    must_doubt(FFP_RULE_UNUSUAL + FFP_RULE_AMBIENT - FFP_RULE_CAMERA_DISTANCE, NULL);
    must_doubt(FFP_RULE_LITTLE_LIT, NULL);
}

// Dark photographs show what is lit all the same.
static void test_dark(void **state) {
    (void)state;
    for (int v = 0; v < capture.n_views; v++)
        for (int p = 0; p < capture.n_patterns; p++) {
            FfpImage *image = &capture.views[v].images[p];
            for (int i = 0; image->data && i < 3 * image->width * image->height; i++) image->data[i] *= 0.05F;
        }
    must_doubt(FFP_RULE_UNDEREXPOSED, NULL);
    must_find(FFP_RULE_LIT_SHARE, NULL);
}

static void test_few_views(void **state) {
    (void)state;
    const int all = capture.n_views;
    capture.n_views = 3;
    must_doubt(FFP_RULE_FEW_VIEWS, NULL);
    capture.n_views = all;
}

// Lit surfaces of a scene may lie beyond its sphere: rays that pass just beside that are looked along too.
static void test_a_scene_reaches_beyond_its_sphere(void **state) {
    (void)state;
    const FfpCamera *camera = &capture.views[0].camera;
    const size_t pixels = (size_t)camera->width * (size_t)camera->height;
    size_t objects = 0, scenes = 0;
    FfpChord narrow, wide;
    for (size_t i = 0; i < pixels; i++) {
        capture.scene = false;
        const bool in = ffp_chord(&capture, camera, i, &narrow);
        capture.scene = true;
        const bool also = ffp_chord(&capture, camera, i, &wide);
        objects += in, scenes += also;
        assert_true(!in || (also && wide.near < narrow.near && wide.far > narrow.far));
    }
    assert_true(objects > 0 && scenes > objects);
}

// Photographs of a Gray code with 32 stripes in place of those of the active pattern, by the true depth, and
// the correspondences that all codes would give.
static void show_stripes(int active, bool coded) {
    const int period = capture.patterns[active].image.width / 16;
    FfpImage *pattern = &capture.patterns[active].image;
    for (int i = 0; i < 3 * pattern->width * pattern->height; i++)
        pattern->data[i] = (real)((i / 3 % pattern->width) / (period / 2) % 2);
    FfpSummed summed = ffp_summed_new(pattern);
    for (int v = 0; v < capture.n_views; v++) {
        FfpView *view = &capture.views[v];
        const int width = view->camera.width, height = view->camera.height;
        if (coded) view->correspondence = ffp_image_new(width, height, 3);
        for (int i = 0; i < width * height; i++) {
            const real *black = view->images[capture.black].data + 3 * i,
                       *white = view->images[capture.white].data + 3 * i, z = view->depth.data[i];
            real ray[3], point[3], at[2], light[3];
            const real cosine =
                ffp_pixel_ray(&view->camera, (real)(i % width) + 0.5F, (real)(i / width) + 0.5F, ray);
            for (int k = 0; k < 3; k++) point[k] = view->camera.pose[4 * k + 3] + z / cosine * ray[k];
            ffp_project(&view->projector, point, &at[0], &at[1]);
            ffp_lookup(&summed, at[0], at[1], 4, 4, light);
            for (int c = 0; c < 3; c++)
                view->images[active].data[3 * i + c] = black[c] + light[c] * (white[c] - black[c]);
            if (!coded || !(z > 0)) continue;
            real *known = view->correspondence.data + 3 * i;
            known[0] = at[0], known[1] = at[1], known[2] = 1;
        }
    }
    ffp_summed_free(&summed);
}

// Every ray meets all colours of stripes: without correspondences they tell nothing, and accuse nobody.
static void test_stripes(void **state) {
    (void)state;
    const int active = ffp_capture_active_pattern(&capture, NULL, NULL);
    show_stripes(active, false);
    assert_int_equal(check(), 1); // the glaze that clips
    must_find(FFP_RULE_PATTERN_BLIND, NULL);
    assert_false(ffp_rig_tells(&capture, active));
    show_stripes(active, true);
    assert_true(ffp_rig_tells(&capture, active));
    assert_int_equal(check(), 1);
    const FfpExplanation e = ffp_rig_explain(&capture, active);
    assert_true(e.pixels > 1500 && e.error < 0.1 && e.chance > 0.3);
}

// With correspondences they tell as much as any pattern: that poses are wrong, and that others were shown.
static void test_wrong_under_stripes(void **state) {
    (void)state;
    SAME_WAY_AGAIN();
    const int active = ffp_capture_active_pattern(&capture, NULL, NULL);
    FfpImage *pattern = &capture.patterns[active].image;
    show_stripes(active, true);
    for (int v = 0; v < capture.n_views; v++) capture.views[v].projector.cx += 40;
    must_doubt(FFP_RULE_CHANCE, NULL);
    for (int v = 0; v < capture.n_views; v++) capture.views[v].projector.cx -= 40;
    for (int i = 0; i < 3 * pattern->width * pattern->height; i++)
        pattern->data[i] = (real)((i / 3 / pattern->width) / 20 % 2);
    must_doubt(FFP_RULE_CHANCE, NULL);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_good, setup, teardown),
        cmocka_unit_test_setup_teardown(test_swapped, setup, teardown),
        cmocka_unit_test_setup_teardown(test_angles_reversed, setup, teardown),
        cmocka_unit_test_setup_teardown(test_axis_moved, setup, teardown),
        cmocka_unit_test_setup_teardown(test_pattern_mirrored, setup, teardown),
        cmocka_unit_test_setup_teardown(test_one_view, setup, teardown),
        cmocka_unit_test_setup_teardown(test_one_view_in_the_light, setup, teardown),
        cmocka_unit_test_setup_teardown(test_few_pixels, setup, teardown),
        cmocka_unit_test_setup_teardown(test_outliers, setup, teardown),
        cmocka_unit_test_setup_teardown(test_slipped, setup, teardown),
        cmocka_unit_test_setup_teardown(test_out_of_focus, setup, teardown),
        cmocka_unit_test_setup_teardown(test_hand_in_a_mask, setup, teardown),
        cmocka_unit_test_setup_teardown(test_projector_off, setup, teardown),
        cmocka_unit_test_setup_teardown(test_projector_counted_otherwise, setup, teardown),
        cmocka_unit_test_setup_teardown(test_projector_turned_away, setup, teardown),
        cmocka_unit_test_setup_teardown(test_unit, setup, teardown),
        cmocka_unit_test_setup_teardown(test_upside_down, setup, teardown),
        cmocka_unit_test_setup_teardown(test_light, setup, teardown),
        cmocka_unit_test_setup_teardown(test_dark, setup, teardown),
        cmocka_unit_test_setup_teardown(test_few_views, setup, teardown),
        cmocka_unit_test_setup_teardown(test_stripes, setup, teardown),
        cmocka_unit_test_setup_teardown(test_wrong_under_stripes, setup, teardown),
        cmocka_unit_test_setup_teardown(test_a_scene_reaches_beyond_its_sphere, setup, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
