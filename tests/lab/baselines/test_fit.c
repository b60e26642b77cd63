// Fits from end to end: one that diverges fails, and a checkpoint serves its own fit only, to the bit.
#include <math.h>
#include "field_scene.h"
#include "lab/baselines/field.h"
#include "scratch.h"

static const int chosen[SCENE_PATTERNS] = {0, 1, 2};
static FfpCapture capture;

static int setup(void **state) {
    capture = scene_capture();
    for (int p = 0; p < SCENE_PATTERNS; p++)
        snprintf(capture.patterns[p].name, sizeof capture.patterns[p].name, "pattern_%d", p);
    return scratch_setup(state);
}

static int teardown(void **state) {
    ffp_capture_free(&capture);
    return scratch_teardown(state);
}

static FfpFieldSettings of_steps(int64_t steps) {
    FfpFieldSettings s = ffp_field_defaults();
    s.steps = steps, s.samples = 2048, s.quiet = true;
    return s;
}

static void fit(FfpNeuralField *field, const FfpFieldSettings *settings) {
    FfpFieldResult result;
    FfpError err = {0};
    if (!ffp_field_fit(field, &capture, chosen, SCENE_PATTERNS, settings, &result, &err))
        fail_msg("%s", err.text);
    assert_int_equal(result.steps, settings->steps);
}

static void refused(const FfpFieldSettings *settings, const char *why) {
    FfpNeuralField field;
    FfpFieldResult result;
    FfpError err = {0};
    assert_false(ffp_field_fit(&field, &capture, chosen, SCENE_PATTERNS, settings, &result, &err));
    if (!strstr(err.text, why)) fail_msg("no '%s' in: %s", why, err.text);
}

// However few steps have passed since the loss was last reported, or remain until its first report.
static void what_diverges_is_refused(void **state) {
    (void)state;
    FfpFieldSettings s = of_steps(7);
    s.grid_rate = s.net_rate = 1e30;
    s.checkpoint = in_scratch("diverged");
    refused(&s, "no longer finite");
    assert_false(ffp_is_file(s.checkpoint));
}

// A budget that is spent already: the same field, the length of its steps along rays too.
static void a_finished_fit_is_read_as_it_was(void **state) {
    (void)state;
    const int64_t steps[2] = {1, 3}; // the first ends with coarse steps, the second with fine ones
    for (int i = 0; i < 2; i++) {
        FfpNeuralField whole, again;
        FfpFieldSettings s = of_steps(steps[i]);
        s.checkpoint = in_scratch(i ? "three" : "one");
        fit(&whole, &s), fit(&again, &s);
        assert_true(again.step == whole.step && (whole.step < 1.0F / 80) == (i == 1));
        assert_memory_equal(whole.parameters, again.parameters, (size_t)whole.layout.count * sizeof(real));
        ffp_neural_field_free(&whole), ffp_neural_field_free(&again);
    }
}

static void a_checkpoint_is_of_its_pictures(void **state) {
    (void)state;
    FfpNeuralField field;
    FfpFieldSettings s = of_steps(1);
    s.checkpoint = in_scratch("own");
    fit(&field, &s), ffp_neural_field_free(&field);
    FfpView *view = &capture.views[1];
    real *const touched[] = {&view->images[2].data[3 * (12 * SCENE_SIDE + 12)],
                             &view->coverage.data[12 * SCENE_SIDE + 12],
                             &view->camera.pose[3],
                             &view->projector.fx,
                             &capture.patterns[2].image.data[7],
                             &capture.intensity[1],
                             &capture.radius};
    for (size_t i = 0; i < sizeof touched / sizeof *touched; i++) {
        const real before = *touched[i];
        *touched[i] = before * 0.875F;
        refused(&s, "another fit");
        *touched[i] = before;
    }
    view->frame_width = SCENE_SIDE - 1, view->frame_height = SCENE_SIDE;
    refused(&s, "another fit");
    view->frame_width = view->frame_height = 0;
    s.noise = 0.01;
    refused(&s, "another fit");
    s.noise = 0, s.mask = 0.2F;
    refused(&s, "another fit");
    s.mask = of_steps(1).mask;
    fit(&field, &s), ffp_neural_field_free(&field);
}

// A name far behind in a long list counts too.
static void long_names_are_not_cut(void **state) {
    (void)state;
    FfpNeuralField field;
    FfpFieldSettings s = of_steps(1);
    char *name = capture.patterns[2].name;
    s.checkpoint = in_scratch("long");
    for (int p = 0; p < SCENE_PATTERNS; p++) memset(capture.patterns[p].name, 'a', FFP_NAME_MAX - 1);
    memset(capture.name, 'b', FFP_NAME_MAX - 1);
    fit(&field, &s), ffp_neural_field_free(&field);
    name[FFP_NAME_MAX - 2] = 'b';
    refused(&s, "another fit");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_diverges_is_refused), cmocka_unit_test(a_finished_fit_is_read_as_it_was),
        cmocka_unit_test(a_checkpoint_is_of_its_pictures), cmocka_unit_test(long_names_are_not_cut)};
    return cmocka_run_group_tests(tests, setup, teardown);
}
