// A training step on a device against the CPU: inputs, losses, gradient, update; and short runs.
#include "compare.h"
#include "core/base/call.h"
#include "core/base/rng.h"
#include "ffprocams.h"
#include "lab/train/captures.h"
#include "lab/train/mirror.h"
#include "scratch.h"
#include "world/synth/synth.h"

static const FfpDevice *device;

static const char tiny_run[] =
    "{\"model\": \"tiny\", \"resolution\": 64, \"pool\": 2, \"reuse\": 2, \"views\": 2, \"targets\": 1,"
    " \"lollipops\": 2, \"pattern_side\": 100, \"samples\": 1, \"ambient_rays\": 1,"
    " \"supervised_inputs\": 1, \"supervised_targets\": 1, \"steps\": 3, \"warmup_steps\": 2,"
    " \"truth_albedo\": 0.1, \"truth_normal\": 0.1, \"truth_roughness\": 0.1,"
    " \"polish_share\": 0, \"polish_steps\": 2, \"validate_every\": 0, \"log_every\": 1}";

static void assert_near(double there, double here, double tolerance, const char *what) {
    print_message("%s: %g, on the CPU %g\n", what, there, here);
    if (!(fabs(there - here) <= tolerance * fabs(here) + 1e-6))
        fail_msg("%s: %g, on the CPU %g", what, there, here);
}

static void compare_losses(const FfpLosses *there, const FfpLosses *here) {
    for (int i = 0; i < FFP_LOSS_TERMS; i++) {
        const bool of_geometry = i == FFP_TERM_DEPTH || i == FFP_TERM_DISTORTION ||
                                 i == FFP_TERM_NORMAL_SMOOTH || i == FFP_TERM_ROUGHNESS_SMOOTH;
        assert_near(there->term[i], here->term[i], of_geometry ? 0.02 : 0.01, ffp_loss_term_names[i]);
    }
    assert_near(there->total, here->total, 0.01, "total");
}

typedef struct Opening {
    FfpScene *scene;
    const FfpTrainConfig *config;
    const FfpCaptureSet *captures; // NULL: generated
} Opening;

static bool open_scene(void *argument, FfpError *err) {
    const Opening *o = argument;
    return o->captures ? ffp_captures_scene(o->scene, o->config, o->captures, 0, err)
                       : ffp_scene_open(o->scene, o->config, NULL, "train", 0, err);
}

// A scene made ready for the device.
static FfpScene opened(const FfpTrainConfig *config, const FfpCaptureSet *captures) {
    FfpScene scene;
    FfpError err = {0};
    FfpContext context = {.device = device};
    if (!ffp_call_run(&context, open_scene, &(Opening){&scene, config, captures}, &err))
        fail_msg("%s", err.text);
    return scene;
}

static FfpTrainConfig tiny_config(double polish_share) {
    FfpTrainConfig config;
    FfpError err = {0};
    assert_true(ffp_train_config_parse(&config, tiny_run, "tiny_run", &err));
    config.polish_share = polish_share;
    return config;
}

// The polish fits what the scene's inputs show, on the device as on the CPU.
static void compare_inputs(const FfpCapture *there, const FfpCapture *here) {
    assert_int_equal(there->n_views, here->n_views);
    for (int v = 0; v < here->n_views; v++)
        for (int p = 0; p < here->n_patterns; p++) {
            const FfpImage *a = &there->views[v].images[p], *b = &here->views[v].images[p];
            assert_true(a->width == b->width && a->height == b->height && !a->data == !b->data);
            if (b->data) assert_close(a->data, b->data, (int64_t)b->width * b->height * 3, 0, "inputs");
        }
}

// Takes the scene away.
static void check_step(const FfpTrainConfig *given, FfpScene scene) {
    const FfpTrainConfig config = *given;
    FfpError err = {0};
    FfpModel *model = ffp_model_new(&config.model, 1, &err);
    const size_t count = (size_t)model->count;
    real *grad = ffp_alloc(count, sizeof *grad);
    FfpLosses here, losses;
    FfpTrainStep *stepper = ffp_train_step_new(&config, NULL);
    if (!ffp_train_step_loss(stepper, model, &scene, 0, &here, grad, &err)) fail_msg("%s", err.text);
    ffp_train_step_free(stepper);
    FfpAdam adam = ffp_adam_new(model);

    ffp_device_use(device);
    FfpMirror *mirror = ffp_mirror_new(model, &adam, &config);
    const FfpScene *there = ffp_mirror_scene(mirror, 0, true, &scene);
    compare_inputs(&there->inputs, &scene.inputs);
    FfpTrainStep *stepper_there = ffp_train_step_new(&config, NULL);
    real *grad_there = ffp_memory_new(count, sizeof *grad_there);
    if (!ffp_train_step_loss(stepper_there, &mirror->model, there, 0, &losses, grad_there, &err))
        fail_msg("%s", err.text);
    compare_losses(&losses, &here);
    assert_close(grad_there, grad, model->count, 0.1, "gradient");
    bool skipped;
    ffp_memory_upload(grad_there, grad, count * sizeof *grad);
    const double norm_there = ffp_adam_update(&mirror->adam, &mirror->model, grad_there, &config, &skipped);
    ffp_device_use(NULL);
    assert_near(norm_there, ffp_adam_update(&adam, model, grad, &config, &skipped), 1e-5, "gradient's norm");
    ffp_device_use(device);
    assert_close(mirror->model.values, model->values, model->count, 1e-6, "updated weights");
    assert_close(mirror->adam.v, adam.v, model->count, 1e-5, "second moments");
    ffp_memory_free(grad_there);
    ffp_train_step_free(stepper_there);
    ffp_mirror_free(mirror, &config);
    ffp_device_use(NULL);
    ffp_free(grad);
    ffp_adam_free(&adam);
    ffp_model_free(model);
    ffp_scene_close(&scene);
}

static void test_step(void **state) {
    (void)state;
    const FfpTrainConfig config = tiny_config(0);
    check_step(&config, opened(&config, NULL));
}

static void test_step_with_a_look(void **state) {
    (void)state;
    FfpTrainConfig config = tiny_config(0);
    config.model.looks = 1;
    check_step(&config, opened(&config, NULL));
}

static void test_step_through_the_polish(void **state) {
    (void)state;
    const FfpTrainConfig config = tiny_config(1);
    check_step(&config, opened(&config, NULL));
}

// Photographs with noise, of a size that is not whole patches.
static void write_capture(const char *folder) {
    FfpSceneSpec spec = ffp_scene_defaults();
    FfpCapture made;
    FfpError err = {0};
    spec.resolution = 36, spec.views = 3, spec.lollipops = 2, spec.pattern_side = 100, spec.samples = 4;
    spec.sensor = (FfpSensor){.read = 0.03F};
    if (!ffp_scene_make(&made, &spec, &err) || !ffp_make_folders(folder, &err) ||
        !ffp_capture_write(&made, folder, &err))
        fail_msg("%s", err.text);
    ffp_capture_free(&made);
}

static void test_step_through_the_polish_of_photographs(void **state) {
    (void)state;
    FfpError err = {0};
    write_capture(in_scratch("captures/a"));
    write_capture(in_scratch("captures/b"));
    FfpTrainConfig config = tiny_config(1);
    snprintf(config.captures, sizeof config.captures, "%s", in_scratch("captures"));
    FfpCaptureSet *captures = ffp_captures_open(&config, &err);
    if (!captures) fail_msg("%s", err.text);
    check_step(&config, opened(&config, captures));
    ffp_captures_close(captures);
}

// The weights that come out of a run on the device.
static FfpModel *weights_of_run(const char *name, const char *config) {
    FfpError err = {0};
    char out[FFP_PATH_MAX], weights[FFP_PATH_MAX];
    snprintf(out, sizeof out, "%s", in_scratch(name));
    assert_true(ffp_join_path(weights, out, "weights.safetensors"));
    assert_true(ffp_write_file(in_scratch("config.json"), config, strlen(config), NULL));
    FfpTraining options = {
        .size = sizeof options, .out = out, .config = in_scratch("config.json"), .steps = -1};
    FfpContext context = {.device = device};
    const bool ok = ffp_train_model(&context, &options, &err);
    if (!ok) fail_msg("%s", err.text);
    FfpModel *model = ffp_model_read(weights, &err);
    if (!model) fail_msg("%s", err.text);
    return model;
}

// Checkpoint, weights and metrics come out of a run on a device as of one on the CPU.
static void test_run(void **state) {
    (void)state;
    FfpError err = {0};
    FfpModel *model = weights_of_run("run", tiny_run);
    FfpModel *fresh = ffp_model_new(&model->config, 0, &err);
    assert_true(distance(model->values, fresh->values, model->count) > 1e-4);
    ffp_model_free(fresh);
    ffp_model_free(model);
}

// The device's turn is the run's till it ends: threads that make its scenes must not wait for it.
static void test_run_with_generators(void **state) {
    (void)state;
    static const char helped[] =
        "{\"generators\": 2, \"model\": \"tiny\", \"resolution\": 16, \"pool\": 1, \"reuse\": 1, \"views\": "
        "2,"
        " \"targets\": 1, \"lollipops\": 1, \"pattern_side\": 64, \"samples\": 1, \"ambient_rays\": 1,"
        " \"supervised_inputs\": 1, \"supervised_targets\": 0, \"steps\": 1, \"validate_every\": 0}";
    alarm(600); // what waits for ever fails
    ffp_model_free(weights_of_run("helped", helped));
    alarm(0);
}

int main(void) {
    if (!(device = find_device())) return 0;
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_step),
                                       cmocka_unit_test(test_step_with_a_look),
                                       cmocka_unit_test(test_step_through_the_polish),
                                       cmocka_unit_test(test_step_through_the_polish_of_photographs),
                                       cmocka_unit_test(test_run),
                                       cmocka_unit_test(test_run_with_generators)};
    return cmocka_run_group_tests(tests, scratch_setup, scratch_teardown);
}
