// Every finding of the checks that other tests do not ask for, in a sample that was changed to raise it.
// Labels: slow
#include <math.h>
#include "core/base/alloc.h"
#include "core/base/rng.h"
#include "rig/checks/found.h"

enum { VIEW = 3, OTHER = 5 };

#define EVERY_VIEW for (FfpView *v = capture.views; v < capture.views + capture.n_views; v++)

static int active_pattern(void) {
    return ffp_capture_active_pattern(&capture, NULL, NULL);
}

static int values_of(const FfpImage *image) {
    return image->channels * image->width * image->height;
}

static void nothing(void) {}

static void move_cameras_aside(void) {
    EVERY_VIEW v->camera.cx += 60;
}

static void narrow_the_projector(void) {
    EVERY_VIEW v->projector.fx *= 4, v->projector.fy *= 4;
}

static void turn_cameras_round(void) {
    EVERY_VIEW
    for (int i = 0; i < 3; i++) v->camera.pose[4 * i] *= -1, v->camera.pose[4 * i + 2] *= -1;
}

static void move_the_axis(void) {
    EVERY_VIEW {
        real *const poses[2] = {v->camera.pose, v->projector.pose};
        for (int k = 0; k < 2; k++)
            for (int i = 0; i < 3; i++) poses[k][4 * i + 3] += 0.1F * poses[0][4 * i];
    }
}

static void leave_a_hand_in_a_mask(void) {
    FfpImage *mask = &capture.views[1].coverage;
    for (int i = 0; i < mask->width * mask->height; i++)
        if (i % mask->width < 30 && i / mask->width > 80) mask->data[i] = 1;
}

// Values of white, from those and those of black.
static void relight(real black, real white, real noise) {
    EVERY_VIEW {
        const real *dark = v->images[capture.black].data;
        real *lit = v->images[capture.white].data;
        for (int i = 0; i < values_of(&v->images[capture.white]); i++)
            lit[i] = black * dark[i] + white * lit[i] + (i % 2 ? noise : -noise);
    }
}

static void light_nothing(void) {
    relight(1, 0, 0.002F);
}

static void light_half(void) {
    EVERY_VIEW {
        const FfpImage *dark = &v->images[capture.black];
        for (int p = 0; p < capture.n_patterns; p++)
            if (v->images[p].data)
                memcpy(v->images[p].data, dark->data, (size_t)values_of(dark) / 2 * sizeof *dark->data);
    }
}

static void darken(void) {
    EVERY_VIEW
    for (int p = 0; p < capture.n_patterns; p++)
        for (int i = 0; v->images[p].data && i < values_of(&v->images[p]); i++) v->images[p].data[i] *= 0.02F;
}

static void light_the_room(void) {
    EVERY_VIEW
    for (int p = 0; p < capture.n_patterns; p++)
        for (int i = 0; v->images[p].data && i < values_of(&v->images[p]) && p != capture.white; i++)
            v->images[p].data[i] += 0.95F * (v->images[capture.white].data[i] - v->images[p].data[i]);
}

static void copy_white(void) {
    ffp_image_free(&capture.views[VIEW].images[capture.white]);
    capture.views[VIEW].images[capture.white] = ffp_image_copy(&capture.views[OTHER].images[capture.white]);
}

static void exchange_channels(void) {
    EVERY_VIEW
    for (int p = 0; p < capture.n_patterns; p++)
        for (int i = 0; v->images[p].data && i < values_of(&v->images[p]); i += 3) {
            real *pixel = v->images[p].data + i, kept = pixel[0];
            pixel[0] = pixel[2], pixel[2] = kept;
        }
}

static void take_another_pattern(void) {
    FfpImage *images = capture.views[VIEW].images + active_pattern(), kept = images[0];
    images[0] = images[1], images[1] = kept;
}

static void invent_a_pattern(void) {
    FfpImage *pattern = &capture.patterns[active_pattern()].image;
    FfpRng rng = ffp_rng(3, 4);
    for (int y = 0; y < pattern->height; y += 8)
        for (int x = 0; x < 3 * pattern->width; x++) {
            const real value =
                x / 3 % 8 ? pattern->data[3 * y * pattern->width + x - 3] : ffp_rng_range(&rng, 0, 1);
            for (int k = y; k < y + 8 && k < pattern->height; k++)
                pattern->data[3 * k * pattern->width + x] = value;
        }
}

static void know_positions(void) {
    EVERY_VIEW v->correspondence = ffp_image_new(v->camera.width, v->camera.height, 3);
    light_nothing();
}

static void make_a_scene(void) {
    capture.scene = true;
}

static void stay_in_one_place(void) {
    make_a_scene();
    EVERY_VIEW memcpy(v->camera.pose, capture.views[0].camera.pose, sizeof v->camera.pose);
}

static void darken_a_scene(void) {
    make_a_scene();
    light_nothing();
}

// One place beside another, a few degrees apart.
static void walk_a_little(void) {
    stay_in_one_place();
    EVERY_VIEW
    for (int i = 0; i < 3; i++)
        v->camera.pose[4 * i + 3] += 0.1F * (real)(v - capture.views) * v->camera.pose[4 * i];
}

static void switch_a_lamp_on(void) {
    for (int p = 0; p < capture.n_patterns; p++) {
        FfpImage *image = &capture.views[VIEW].images[p];
        for (int i = 0; image->data && i < values_of(image); i++) image->data[i] += 1;
    }
}

static const struct {
    FfpRuleId rule;
    void (*change)(void);
    int side; // of the photographs; 0: as they are
} cases[] = {
    {FFP_RULE_FRUSTA, nothing, 0},
    {FFP_RULE_LIT_PIXELS, nothing, 0},
    {FFP_RULE_SILHOUETTES, nothing, 0},
    {FFP_RULE_EXPOSURE, nothing, 0},
    {FFP_RULE_BLACK_LEVEL, nothing, 0},
    {FFP_RULE_VIEWS, nothing, 0},
    {FFP_RULE_SIZE, nothing, 0},
    {FFP_RULE_PATTERN, nothing, 0},
    {FFP_RULE_SURFACES, nothing, 0},
    {FFP_RULE_LARGE, nothing, 1200},
    {FFP_RULE_SMALL, nothing, 64},
    {FFP_RULE_OBJECT_CUT_OFF, move_cameras_aside, 0},
    {FFP_RULE_PATTERN_TOO_SMALL, narrow_the_projector, 0},
    {FFP_RULE_AXES, turn_cameras_round, 0},
    {FFP_RULE_NOTE_VIEW_CONTRADICTS, leave_a_hand_in_a_mask, 0},
    {FFP_RULE_NOTE_VIEWS_CONTRADICT, move_the_axis, 0},
    {FFP_RULE_NOTE_UNDEREXPOSED, darken, 0},
    {FFP_RULE_CLIPPING, darken, 0},
    {FFP_RULE_SAME_VIEW, copy_white, 0},
    {FFP_RULE_LAMP, switch_a_lamp_on, 0},
    {FFP_RULE_BRIGHT_ROOM, light_the_room, 0},
    {FFP_RULE_PROJECTOR_DARK, light_nothing, 0},
    {FFP_RULE_NONE_LIT, light_nothing, 0},
    {FFP_RULE_GUESSED, light_half, 0},
    {FFP_RULE_CODED, know_positions, 0},
    {FFP_RULE_RED_AND_BLUE, exchange_channels, 0},
    {FFP_RULE_OTHER_PATTERN_ONCE, take_another_pattern, 0},
    {FFP_RULE_NOTE_CHANCE, invent_a_pattern, 0},
    {FFP_RULE_DEPTH, make_a_scene, 0},
    {FFP_RULE_SCENE_LIT, make_a_scene, 0},
    {FFP_RULE_WIDE_PARALLAX, make_a_scene, 0},
    {FFP_RULE_NO_PARALLAX, stay_in_one_place, 0},
    {FFP_RULE_PARALLAX, walk_a_little, 0},
    {FFP_RULE_SCENE_DARK, darken_a_scene, 0},
};

static void every_change_is_named(void **state) {
    (void)state;
    int change = 0;
    bool left_out = false;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const bool same =
            i > 0 && cases[i].change == cases[i - 1].change && cases[i].side == cases[i - 1].side;
        FfpCamera taken;
        if (!same) left_out = change++ % TIMES(1, 5) != 0;
        if (left_out) continue;
        if (!same) {
            teardown(NULL);
            assert_int_equal(setup(NULL), 0);
            cases[i].change();
            taken = capture.views[0].camera;
            if (cases[i].side) taken.width = taken.height = cases[i].side;
            ffp_rig_faults(&found, &capture);
            ffp_rig_checks(&found, &capture, &taken);
        }
        must_find(cases[i].rule, NULL);
    }
    teardown(NULL);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(every_change_is_named)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
