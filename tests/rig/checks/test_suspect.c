// People's mistakes: each is named with its view, and nothing is said of captures without one.
#include <math.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "core/base/vec.h"
#include "core/image/srgb_formula.h"
#include "rig/checks/found.h"
#include "rig/checks/hypotheses.h"

enum { VIEW = 3, OTHER = 5 };

// As a fault; of no view: of all.
static const FfpFinding *must_name(FfpRuleId rule, const char *view) {
    FfpError err = {0};
    ffp_findings_free(&found);
    assert_false(ffp_rig_faults(&found, &capture));
    const FfpFinding *fault = ffp_findings_fault(&found);
    assert_ptr_equal(must_find(rule, view), fault);
    assert_true((view != NULL) == (fault->view != NULL));
    assert_false(ffp_findings_tell(&found, capture.folder, &err));
    assert_int_equal(err.code, FFP_ERROR_FAULT);
    assert_non_null(strstr(err.text, view ? view : capture.folder));
    return fault;
}

static void nothing_is_wrong(void **state) {
    (void)state;
    FfpError err = {0};
    assert_true(ffp_rig_suspect(&capture, &err));
    for (int n = 1; n < 8; n++) { // of fewer views too
        capture.n_views = n;
        assert_true(ffp_rig_suspect(&capture, &err));
    }
    capture.n_views = 8;
}

typedef enum Move { HALF_TURN, TO_THE_LEFT, TO_THE_RIGHT, MIRROR, FLIP, MOVES } Move;

// A square picture as a careless hand leaves it.
static void move_picture(FfpImage *image, Move move) {
    if (!image->data) return;
    const int side = image->width, last = side - 1, n = image->channels;
    FfpImage out = ffp_image_new(side, side, n);
    assert_int_equal(image->height, side);
    for (int y = 0; y < side; y++)
        for (int x = 0; x < side; x++) {
            const int from[MOVES][2] = {
                [HALF_TURN] = {last - x, last - y},
                [TO_THE_LEFT] = {last - y, x}, // the right upper corner comes to the left
                [TO_THE_RIGHT] = {y, last - x},
                [MIRROR] = {last - x, y},
                [FLIP] = {x, last - y}};
            const real *pixel = image->data + (ptrdiff_t)n * (from[move][1] * side + from[move][0]);
            memcpy(out.data + (ptrdiff_t)n * (y * side + x), pixel, (size_t)n * sizeof *pixel);
        }
    ffp_image_free(image);
    *image = out;
}

static void one_view_turned_or_mirrored(void **state) {
    static const char *const turns[MOVES] = {[HALF_TURN] = "180",
                                             [TO_THE_LEFT] = "left",
                                             [TO_THE_RIGHT] = "right",
                                             [MIRROR] = "left to",
                                             [FLIP] = "upside"};
    for (int move = 0; move < MOVES; move++) {
        teardown(state);
        assert_int_equal(setup(state), 0);
        FfpView *view = &capture.views[VIEW];
        for (int p = 0; p < capture.n_patterns; p++) move_picture(&view->images[p], (Move)move);
        move_picture(&view->coverage, (Move)move);
        assert_non_null(strstr(must_name(FFP_RULE_VIEW_TURNED, view->id)->text, turns[move]));
    }
}

static void exchange_photographs(FfpView *a, FfpView *b) {
    const FfpView kept = *a;
    a->images = b->images;
    a->coverage = b->coverage;
    b->images = kept.images;
    b->coverage = kept.coverage;
}

// No view is odd by its silhouettes, but each by its light.
static void three_views_upside_down(void **state) {
    (void)state;
    for (int v = 2; v < 5; v++) {
        FfpView *view = &capture.views[v];
        for (int p = 0; p < capture.n_patterns; p++) move_picture(&view->images[p], HALF_TURN);
        move_picture(&view->coverage, HALF_TURN);
    }
    ffp_findings_free(&found);
    assert_false(ffp_rig_faults(&found, &capture));
    assert_non_null(strstr(must_find(FFP_RULE_VIEW_TURNED, NULL)->text, "180"));
}

// The projector's motion from the camera, X_projector = R X_camera + T: the inverse of what was meant, or
// with R transposed.
static void motion_of_the_projector(void **state) {
    for (int transposed = 0; transposed < 2; transposed++) {
        teardown(state);
        assert_int_equal(setup(state), 0);
        for (int v = 0; v < capture.n_views; v++) {
            const real *c = capture.views[v].camera.pose;
            real *p = capture.views[v].projector.pose, r[9] = {0}, t[3] = {0};
            for (int i = 0; i < 9; i++)
                for (int j = 0; j < 3; j++) r[i] += p[4 * j + i / 3] * c[4 * j + i % 3];
            for (int i = 0; i < 9; i++)
                t[i / 3] += p[4 * (i % 3) + i / 3] * (c[4 * (i % 3) + 3] - p[4 * (i % 3) + 3]);
            // The camera's pose times (R, T), or times the inverse of (R^T, T), which is (R, -R T).
            if (transposed) {
                const real turned[3] = {-ffp_dot3(r, t), -ffp_dot3(r + 3, t), -ffp_dot3(r + 6, t)};
                memcpy(t, turned, sizeof t);
            }
            for (int i = 0; i < 3; i++) {
                for (int k = 0; k < 3; k++)
                    p[4 * i + k] = c[4 * i] * r[k] + c[4 * i + 1] * r[3 + k] + c[4 * i + 2] * r[6 + k];
                p[4 * i + 3] = c[4 * i + 3] + ffp_dot3(c + 4 * i, t);
            }
        }
        assert_non_null(
            strstr(must_name(FFP_RULE_PROJECTOR_INVERTED, NULL)->text, transposed ? "rotation" : "poses"));
    }
}

static void two_views_exchanged(void **state) {
    (void)state;
    exchange_photographs(&capture.views[VIEW], &capture.views[OTHER]);
    assert_string_equal(must_name(FFP_RULE_VIEWS_EXCHANGED, capture.views[VIEW].id)->other,
                        capture.views[OTHER].id);
}

static void a_turntable_that_turned_the_other_way(void **state) {
    (void)state;
    for (int v = 1; v < 4; v++) exchange_photographs(&capture.views[v], &capture.views[8 - v]);
    must_name(FFP_RULE_OTHER_DIRECTION, NULL);
}

static void all_views_mirrored(void **state) {
    for (int flip = 0; flip < 2; flip++) {
        teardown(state);
        assert_int_equal(setup(state), 0);
        for (int v = 0; v < capture.n_views; v++) {
            FfpView *view = &capture.views[v];
            for (int p = 0; p < capture.n_patterns; p++) move_picture(&view->images[p], flip ? FLIP : MIRROR);
            move_picture(&view->coverage, flip ? FLIP : MIRROR);
        }
        assert_non_null(strstr(must_name(FFP_RULE_ALL_MIRRORED, NULL)->text, flip ? "upside" : "left"));
    }
}

static void exchange_black_and_white(FfpView *view) {
    const FfpImage black = view->images[capture.black];
    view->images[capture.black] = view->images[capture.white];
    view->images[capture.white] = black;
}

static void black_and_white_exchanged(void **state) {
    (void)state;
    exchange_black_and_white(&capture.views[VIEW]);
    must_name(FFP_RULE_EXCHANGED, capture.views[VIEW].id);
    for (int v = 0; v < capture.n_views; v++)
        if (v != VIEW) exchange_black_and_white(&capture.views[v]);
    must_name(FFP_RULE_EXCHANGED, NULL);
}

static void devices_where_they_cannot_be(void **state) {
    (void)state;
    FfpCamera *projector = &capture.views[VIEW].projector;
    const FfpCamera kept = *projector;
    for (int i = 0; i < 3; i++)
        projector->pose[4 * i + 3] = capture.centre[i] - 0.1F * capture.radius * kept.pose[4 * i + 2];
    must_name(FFP_RULE_DEVICE_INSIDE, capture.views[VIEW].id);
    *projector = kept;
    FfpCamera *camera = &capture.views[OTHER].camera;
    for (int i = 0; i < 3; i++) { // turned round
        camera->pose[4 * i] = -camera->pose[4 * i];
        camera->pose[4 * i + 2] = -camera->pose[4 * i + 2];
    }
    must_name(FFP_RULE_DEVICE_BEHIND, capture.views[OTHER].id);
}

// --- Photographs of another pattern, of another view, or of nothing. ---

static void exchange_pictures(FfpImage *a, FfpImage *b) {
    const FfpImage kept = *a;
    *a = *b;
    *b = kept;
}

static void photographs_of_something_else(void **state) {
    (void)state;
    FfpView *view = &capture.views[VIEW], *other = &capture.views[OTHER];
    const int active = ffp_capture_active_pattern(&capture, NULL, NULL);
    exchange_pictures(&view->images[active], &other->images[active]);
    assert_string_equal(must_name(FFP_RULE_PATTERN_EXCHANGED, other->id)->other, view->id);
    exchange_pictures(&view->images[active], &other->images[active]);
    exchange_pictures(&view->images[active], &view->images[capture.white]);
    must_name(FFP_RULE_EXCHANGED, view->id);
    exchange_pictures(&view->images[active], &view->images[capture.white]);
    const FfpImage kept = view->images[active];
    view->images[active] = ffp_image_copy(&view->images[capture.white]);
    must_name(FFP_RULE_SAME_PHOTOGRAPH, view->id);
    ffp_image_free(&view->images[active]);
    view->images[active] = kept;
    exchange_pictures(&capture.patterns[active].image, &capture.patterns[active + 1].image);
    assert_non_null(strstr(must_name(FFP_RULE_OTHER_PATTERN, NULL)->text, "lollipop_1"));
    exchange_pictures(&capture.patterns[active].image, &capture.patterns[active + 1].image);
    move_picture(&capture.patterns[active].image, MIRROR);
    assert_non_null(strstr(must_name(FFP_RULE_PATTERN_MIRRORED, NULL)->text, "left to right"));
}

// A sheet of paper. Another view looks just the same, and its photograph fits: but they are not exchanged.
static void something_in_front_of_one_view(void **state) {
    (void)state;
    const int active = ffp_capture_active_pattern(&capture, NULL, NULL);
    const int shown[3] = {capture.black, capture.white, active};
    FfpView *view = &capture.views[VIEW], *other = &capture.views[OTHER];
    other->camera = view->camera;
    other->projector = view->projector;
    ffp_image_free(&other->coverage);
    other->coverage = ffp_image_copy(&view->coverage);
    for (int k = 0; k < 3; k++) {
        ffp_image_free(&other->images[shown[k]]);
        other->images[shown[k]] = ffp_image_copy(&view->images[shown[k]]);
    }
    const real *black = view->images[capture.black].data, *white = view->images[capture.white].data;
    FfpImage *seen = &view->images[active];
    for (int i = 0; i < 3 * seen->width * seen->height; i++)
        seen->data[i] = black[i] + 0.7F * (white[i] - black[i]);
    must_name(FFP_RULE_PATTERN_NOT_THERE, view->id);
}

// --- Values, light and units. ---

static FfpImage *shown(FfpView *view, int k) {
    const int patterns[3] = {capture.black, capture.white, ffp_capture_active_pattern(&capture, NULL, NULL)};
    return &view->images[patterns[k]];
}

// Photographs in linear light that were read as sRGB, and in sRGB that were read as linear light.
static void values_taken_for_others(void **state) {
    for (int variant = 0; variant < 2; variant++) {
        teardown(state);
        assert_int_equal(setup(state), 0);
        for (int i = 0; i < 3 * 8; i++) {
            FfpImage *image = shown(&capture.views[i / 3], i % 3);
            for (int k = 0; k < 3 * image->width * image->height; k++)
                image->data[k] = variant ? ffp_srgb_encode(image->data[k]) : ffp_srgb_decode(image->data[k]);
        }
        assert_non_null(strstr(must_name(FFP_RULE_ENCODING, NULL)->text, variant ? "sRGB" : "linear light"));
    }
}

static void a_camera_without_colour(void **state) {
    (void)state;
    for (int i = 0; i < 3 * 8; i++) {
        FfpImage *image = shown(&capture.views[i / 3], i % 3);
        for (real *p = image->data; p < image->data + 3 * image->width * image->height; p += 3)
            p[0] = p[2] = p[1];
    }
    must_name(FFP_RULE_GREY, NULL);
}

static void one_photograph_exposed_otherwise(void **state) {
    (void)state;
    FfpImage *active = shown(&capture.views[VIEW], 2);
    for (int i = 0; i < 3 * active->width * active->height; i++) active->data[i] *= 0.6F;
    must_name(FFP_RULE_EXPOSED_OTHERWISE, capture.views[VIEW].id);
}

// White, photographed again with its own noise in place of the pattern; and the room's light on under black.
static void one_photograph_in_another_light(void **state) {
    (void)state;
    FfpView *view = &capture.views[VIEW];
    FfpImage *black = shown(view, 0), *white = shown(view, 1), *active = shown(view, 2);
    const int n = 3 * white->width * white->height;
    for (int i = 0; i < n; i++) black->data[i] += 0.2F * view->coverage.data[i / 3];
    must_name(FFP_RULE_BLACK_LIT, view->id);
    for (int i = 0; i < n; i++) black->data[i] -= 0.2F * view->coverage.data[i / 3];
    for (int i = 0; i < n; i++) active->data[i] = white->data[i] + (i % 2 ? 0.002F : -0.002F);
    must_name(FFP_RULE_SAME_PHOTOGRAPH, view->id);
}

static void a_baseline_in_another_unit(void **state) {
    (void)state;
    for (int v = 0; v < 8; v++) {
        real *camera = capture.views[v].camera.pose, *projector = capture.views[v].projector.pose;
        for (int i = 3; i < 12; i += 4) projector[i] = camera[i] + 0.001F * (projector[i] - camera[i]);
    }
    must_name(FFP_RULE_TOGETHER, NULL);
}

// Of an object that looks alike from both sides, surfaces tell what silhouettes and the pattern do not.
static void two_views_exchanged_by_their_surfaces(void **state) {
    (void)state;
    FfpCase c = {.capture = &capture, .view = OTHER, .compared = 8, .enough = 1};
    c.active = ffp_capture_active_pattern(&capture, NULL, NULL);
    ffp_findings_free(&found);
    assert_true(ffp_hypotheses_try(&found, FFP_VIEW_BY_DEPTH, &c));
    exchange_photographs(&capture.views[VIEW], &capture.views[OTHER]);
    assert_false(ffp_hypotheses_try(&found, FFP_VIEW_BY_DEPTH, &c));
    must_find(FFP_RULE_VIEWS_EXCHANGED, capture.views[VIEW].id);
}

// A vase turned the other way, and a camera's size where silhouettes do not tell: by surfaces and by light.
static void what_silhouettes_do_not_tell(void **state) {
    const int active = ffp_capture_active_pattern(&capture, NULL, NULL);
    FfpCase c = {.capture = &capture, .active = active, .view = -1, .compared = 8, .enough = 1};
    FfpSummed pattern = ffp_summed_new(&capture.patterns[active].image);
    c.pattern = &pattern;
    ffp_findings_free(&found);
    for (int v = 1; v < 4; v++) exchange_photographs(&capture.views[v], &capture.views[8 - v]);
    assert_false(ffp_hypotheses_try(&found, FFP_VIEWS_BY_DEPTH, &c));
    must_find(FFP_RULE_OTHER_DIRECTION, NULL);
    teardown(state);
    assert_int_equal(setup(state), 0);
    for (int v = 0; v < capture.n_views; v++) {
        FfpCamera *d = &capture.views[v].camera;
        d->fx *= 2, d->fy *= 2, d->cx *= 2, d->cy *= 2;
    }
    c.enough = 0.5 * ffp_error_of(&capture, active, -1, (FfpGuess){.pattern = &pattern});
    assert_false(ffp_hypotheses_try(&found, FFP_VIEWS_BY_LIGHT, &c));
    must_find(FFP_RULE_CAMERA_SIZE, NULL);
    ffp_summed_free(&pattern);
}

static void calibrations_of_another_size(void **state) {
    (void)state;
    for (int v = 0; v < capture.n_views; v++) {
        FfpCamera *p = &capture.views[v].projector;
        p->fx *= 0.5F, p->fy *= 0.5F;
        p->cx *= 0.5F, p->cy *= 0.5F;
    }
    assert_non_null(strstr(must_name(FFP_RULE_PROJECTOR_SIZE, NULL)->advice, "400 x 400"));
    teardown(state);
    assert_int_equal(setup(state), 0);
    for (int v = 0; v < capture.n_views; v++) {
        FfpCamera *c = &capture.views[v].camera;
        c->fx *= 2, c->fy *= 2;
        c->cx *= 2, c->cy *= 2;
    }
    assert_non_null(strstr(must_name(FFP_RULE_CAMERA_SIZE, NULL)->text, "half"));
}

static void masks_that_are_none(void **state) {
    (void)state;
    FfpImage *mask = &capture.views[VIEW].coverage;
    const ptrdiff_t pixels = (ptrdiff_t)mask->width * mask->height;
    for (ptrdiff_t i = 0; i < pixels; i++) mask->data[i] = 1 - mask->data[i];
    must_name(FFP_RULE_MASK_INVERTED, capture.views[VIEW].id);
    for (ptrdiff_t i = 0; i < pixels; i++) mask->data[i] = 0;
    must_name(FFP_RULE_MASK_EMPTY, capture.views[VIEW].id);
}

// Nine stops at each of the sample's eight places, of which one is upside down: a share of the pixels that is
// nine times smaller.
static void one_of_seventy_two_views(void **state) {
    (void)state;
    enum { TIMES = 9, ODD = 40 };
    FfpView *own = capture.views, *many = ffp_alloc((size_t)TIMES * 8, sizeof *many);
    for (int v = 0; v < TIMES * 8; v++) {
        many[v] = own[v % 8];
        snprintf(many[v].id, sizeof many[v].id, "stop_%d", v);
    }
    FfpView *odd = &many[ODD];
    odd->coverage = ffp_image_copy(&odd->coverage);
    odd->images = ffp_alloc((size_t)capture.n_patterns, sizeof *odd->images);
    for (int p = 0; p < capture.n_patterns; p++)
        if (own[ODD % 8].images[p].data) odd->images[p] = ffp_image_copy(&own[ODD % 8].images[p]);
    capture.views = many;
    capture.n_views = TIMES * 8;
    FfpError err = {0};
    assert_true(ffp_rig_suspect(&capture, &err));
    move_picture(&odd->coverage, HALF_TURN);
    for (int p = 0; p < capture.n_patterns; p++) move_picture(&odd->images[p], HALF_TURN);
    must_name(FFP_RULE_VIEW_TURNED, "stop_40");
    ffp_image_free(&odd->coverage);
    for (int p = 0; p < capture.n_patterns; p++) ffp_image_free(&odd->images[p]);
    ffp_free(odd->images);
    ffp_free(many);
    capture.views = own;
    capture.n_views = 8;
}

static bool check(void *argument, FfpError *err) {
    (void)argument;
    return ffp_rig_suspect(&capture, err);
}

// By its caller, at any of its points.
static int points_left;

static bool stop_later(void *user, const FfpProgress *progress) {
    (void)user, (void)progress;
    return points_left-- > 0;
}

static void checks_can_be_cancelled(void **state) {
    (void)state;
    FfpContext context = {.settings = {.progress = stop_later}};
    for (points_left = 0; points_left < 40; points_left += 10) {
        const int points = points_left;
        FfpError err = {0};
        assert_false(ffp_call_run(&context, check, NULL, &err));
        assert_int_equal(err.code, FFP_ERROR_CANCELLED);
        points_left = points;
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(nothing_is_wrong, setup, teardown),
        cmocka_unit_test_setup_teardown(one_view_turned_or_mirrored, setup, teardown),
        cmocka_unit_test_setup_teardown(three_views_upside_down, setup, teardown),
        cmocka_unit_test_setup_teardown(motion_of_the_projector, setup, teardown),
        cmocka_unit_test_setup_teardown(all_views_mirrored, setup, teardown),
        cmocka_unit_test_setup_teardown(two_views_exchanged, setup, teardown),
        cmocka_unit_test_setup_teardown(a_turntable_that_turned_the_other_way, setup, teardown),
        cmocka_unit_test_setup_teardown(black_and_white_exchanged, setup, teardown),
        cmocka_unit_test_setup_teardown(photographs_of_something_else, setup, teardown),
        cmocka_unit_test_setup_teardown(something_in_front_of_one_view, setup, teardown),
        cmocka_unit_test_setup_teardown(values_taken_for_others, setup, teardown),
        cmocka_unit_test_setup_teardown(a_camera_without_colour, setup, teardown),
        cmocka_unit_test_setup_teardown(one_photograph_in_another_light, setup, teardown),
        cmocka_unit_test_setup_teardown(one_photograph_exposed_otherwise, setup, teardown),
        cmocka_unit_test_setup_teardown(a_baseline_in_another_unit, setup, teardown),
        cmocka_unit_test_setup_teardown(two_views_exchanged_by_their_surfaces, setup, teardown),
        cmocka_unit_test_setup_teardown(what_silhouettes_do_not_tell, setup, teardown),
        cmocka_unit_test_setup_teardown(calibrations_of_another_size, setup, teardown),
        cmocka_unit_test_setup_teardown(masks_that_are_none, setup, teardown),
        cmocka_unit_test_setup_teardown(devices_where_they_cannot_be, setup, teardown),
        cmocka_unit_test_setup_teardown(one_of_seventy_two_views, setup, teardown),
        cmocka_unit_test_setup_teardown(checks_can_be_cancelled, setup, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
