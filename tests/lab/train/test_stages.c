// The staged supervision: what each stage counts, from which step on, and that the perceptual term sees what
// the others see.
#include "core/base/alloc.h"
#include "core/base/rng.h"
#include "engine/loss/perceptual_net.h"
#include "engine/render/pass.h"
#include "lab/train/train.h"
#include "random_perceptual.h"
#include "scratch.h"

enum { LATER = 1000, WHITE_FROM = 40, ACTIVE_FROM = 70 };

// One view and one lollipop: nothing is left to chance but the supervised view's number.
static const char one_view[] =
    "{\"model\": {\"preset\": \"paper-small\", \"dim\": 64, \"modules\": \"MT\"}, \"resolution\": 32, "
    "\"views\": 1, \"targets\": 0, \"lollipops\": 1, \"pattern_side\": 100, \"samples\": 1, "
    "\"ambient_rays\": 1, \"supervised_inputs\": 1, \"supervised_targets\": 0, \"perceptual\": 1, "
    "\"perceptual_from\": 0, \"white_from\": 40, \"active_from\": 70}";

typedef struct Bench {
    FfpTrainConfig config;
    FfpScene scene;
    FfpModel *model;
    FfpPerceptual *perceptual;
    real *grad;
} Bench;

static Bench open_bench(void) {
    Bench b = {.perceptual = random_perceptual(FFP_PERCEPTUAL_VGG16)};
    FfpError err = {0};
    if (!ffp_train_config_parse(&b.config, one_view, "one_view", &err) ||
        !ffp_scene_open(&b.scene, &b.config, NULL, "train", 0, &err))
        fail_msg("%s", err.text);
    b.model = ffp_model_new(&b.config.model, 1, &err);
    b.grad = ffp_alloc((size_t)b.model->count, sizeof *b.grad);
    return b;
}

static void close_bench(Bench *b) {
    ffp_free(b->grad);
    ffp_model_free(b->model);
    ffp_scene_close(&b->scene);
    ffp_perceptual_free(b->perceptual);
}

// The terms of a step, and the Gaussians' picture under each of `patterns` measured one by one.
static FfpLosses losses_at(Bench *b, int64_t step, const int *patterns, int count, FfpLosses *measured) {
    FfpLosses losses;
    FfpError err = {0};
    FfpTrainStep *stepper = ffp_train_step_new(&b->config, b->perceptual);
    if (!ffp_train_step_loss(stepper, b->model, &b->scene, step, &losses, b->grad, &err))
        fail_msg("%s", err.text);
    const FfpCapture *capture = &b->scene.capture;
    const FfpView *view = &capture->views[0];
    const FfpRenderSettings settings = ffp_render_settings(true, 1);
    *measured = (FfpLosses){0};
    for (int i = 0; i < count; i++) {
        const FfpSummed *light = patterns[i] == capture->black ? NULL : &b->scene.patterns[patterns[i]];
        FfpImage picture = ffp_render_view(&ffp_train_step_run(stepper)->gaussians, &view->camera,
                                           &view->projector, capture->intensity, light, &settings);
        FfpImage target = ffp_image_copy(&view->images[patterns[i]]);
        ffp_image_to_srgb(&target);
        measured->term[FFP_TERM_L1] += (double)ffp_l1_loss(&picture, &target, (real)b->config.l1, NULL);
        measured->term[FFP_TERM_SSIM] += (double)ffp_ssim_loss(&picture, &target, (real)b->config.ssim, NULL);
        measured->term[FFP_TERM_PERCEPTUAL] +=
            (double)ffp_perceptual_loss(b->perceptual, &picture, &target, (real)b->config.perceptual, NULL);
        ffp_image_free(&picture);
        ffp_image_free(&target);
    }
    ffp_train_step_free(stepper);
    return losses;
}

static void assert_counts(Bench *b, int64_t step, const int *patterns, int count) {
    FfpLosses measured;
    const FfpLosses losses = losses_at(b, step, patterns, count, &measured);
    for (int t = FFP_TERM_L1; t <= FFP_TERM_PERCEPTUAL; t++) {
        assert_true(measured.term[t] > 0);
        if (fabs(losses.term[t] - measured.term[t]) > 1e-5 * measured.term[t])
            fail_msg("step %d, %s: %g, not %g", (int)step, ffp_loss_term_names[t], losses.term[t],
                     measured.term[t]);
    }
}

static void each_stage_adds_a_picture(void **state) {
    (void)state;
    Bench b = open_bench();
    const FfpCapture *capture = &b.scene.capture;
    const int order[3] = {capture->black, capture->white, 3 - capture->black - capture->white};
    assert_int_equal(capture->n_patterns, 3);
    assert_counts(&b, 0, order, 1);
    assert_counts(&b, WHITE_FROM - 1, order, 1);
    assert_counts(&b, WHITE_FROM, order, 2);
    assert_counts(&b, ACTIVE_FROM - 1, order, 2);
    assert_counts(&b, ACTIVE_FROM, order, 3);
    close_bench(&b);
}

// A step is an update of the weights, whatever the batch; without the fields everything counts at once.
static void steps_are_not_draws(void **state) {
    (void)state;
    Bench b = open_bench();
    const FfpCapture *capture = &b.scene.capture;
    const int order[3] = {capture->black, capture->white, 3 - capture->black - capture->white};
    b.config.batch = 2;
    assert_counts(&b, 2 * WHITE_FROM - 1, order, 1);
    assert_counts(&b, 2 * WHITE_FROM, order, 2);
    b.config.batch = 1;
    b.config.white_from = ffp_train_defaults().white_from;
    b.config.active_from = ffp_train_defaults().active_from;
    b.config.perceptual_from = LATER;
    FfpLosses measured;
    const FfpLosses losses = losses_at(&b, 0, order, 3, &measured);
    assert_true(losses.term[FFP_TERM_PERCEPTUAL] == 0);
    assert_float_equal(losses.term[FFP_TERM_L1], measured.term[FFP_TERM_L1], 1e-5);
    close_bench(&b);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(each_stage_adds_a_picture),
                                       cmocka_unit_test(steps_are_not_draws)};
    return cmocka_run_group_tests(tests, scratch_setup, scratch_teardown);
}
