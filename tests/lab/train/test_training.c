// Training as a whole: it can learn, and a resumed run repeats the bits of one that was never stopped.
// Labels: threads
#include <jansson.h>
#include <signal.h>
#include <sys/resource.h>
#include "core/base/alloc.h"
#include "engine/loss/metrics.h"
#include "engine/render/pass.h"
#include "lab/train/train.h"
#include "scratch.h"

static const char tiny_run[] =
    "{\"model\": \"tiny\", \"resolution\": 64, \"pool\": 2, \"reuse\": 2, \"views\": 4, \"targets\": 1,"
    " \"lollipops\": 2, \"pattern_side\": 200, \"samples\": 1, \"ambient_rays\": 1,"
    " \"supervised_inputs\": 1, \"supervised_targets\": 1, \"steps\": 6, \"warmup_steps\": 2,"
    " \"polish_share\": 0.5, \"polish_steps\": 5, \"validate_every\": 0, \"log_every\": 1}";

static void train(const char *out, const char *config, int64_t stop_at, bool resume) {
    FfpError err = {0};
    const FfpTrainRun options = {
        .out = out, .config = config, .steps = -1, .stop_at = stop_at, .resume = resume};
    if (!ffp_train_run(&options, &err)) fail_msg("%s", err.text);
}

static void assert_same_files(const char *a, const char *b) {
    char *left, *right;
    size_t left_size, right_size;
    assert_true(ffp_read_file(a, 1 << 28, &left, &left_size, NULL));
    assert_true(ffp_read_file(b, 1 << 28, &right, &right_size, NULL));
    assert_int_equal(left_size, right_size);
    assert_memory_equal(left, right, left_size);
    ffp_free(left);
    ffp_free(right);
}

static void test_resume(void **state) {
    (void)state;
    assert_true(ffp_write_file(in_scratch("config.json"), tiny_run, strlen(tiny_run), NULL));
    train(in_scratch("straight"), in_scratch("config.json"), 0, false);
    train(in_scratch("stopped"), in_scratch("config.json"), 3, false);
    train(in_scratch("stopped"), NULL, 0, true);
    assert_same_files(in_scratch("straight/checkpoint.safetensors"),
                      in_scratch("stopped/checkpoint.safetensors"));
    assert_same_files(in_scratch("straight/weights.safetensors"), in_scratch("stopped/weights.safetensors"));
}

// Whoever makes the scenes, and wherever the run was stopped: the same weights and moments.
static void test_generators(void **state) {
    (void)state;
    static const char *const names[2] = {"alone", "helped"};
    static const int generators[2] = {0, 3};
    FfpModel *models[2];
    FfpAdam adams[2];
    for (int i = 0; i < 2; i++) {
        char text[sizeof tiny_run + 64], origin[FFP_ORIGIN_MAX], path[FFP_PATH_MAX];
        snprintf(text, sizeof text, "{\"generators\": %d, \"queue\": 3, %s", generators[i], tiny_run + 1);
        assert_true(ffp_write_file(in_scratch("config.json"), text, strlen(text), NULL));
        train(in_scratch(names[i]), in_scratch("config.json"), i ? 3 : 0, false);
        if (i) train(in_scratch(names[i]), NULL, 0, true);
        FfpTrainConfig config;
        FfpError err = {0};
        assert_true(ffp_join_path(path, in_scratch(names[i]), "checkpoint.safetensors"));
        models[i] = ffp_checkpoint_read(path, &adams[i], &config, origin, &err);
        if (!models[i]) fail_msg("%s", err.text);
        assert_int_equal(adams[i].step, 6);
        assert_int_equal(config.generators, generators[i]);
    }
    const size_t size = (size_t)models[0]->count * sizeof(real);
    assert_memory_equal(models[0]->values, models[1]->values, size);
    assert_memory_equal(adams[0].ema, adams[1].ema, size);
    assert_memory_equal(adams[0].m, adams[1].m, size);
    assert_memory_equal(adams[0].v, adams[1].v, size);
    for (int i = 0; i < 2; i++) {
        ffp_model_free(models[i]);
        ffp_adam_free(&adams[i]);
    }
}

// Where every step looks through the fit, the gradient is another one, and still one that training can
// follow.
static void test_training_looks_through_the_polish(void **state) {
    (void)state;
    FfpTrainConfig config;
    FfpError err = {0};
    assert_true(ffp_train_config_parse(&config, tiny_run, "tiny_run", &err));
    FfpScene scene;
    assert_true(ffp_scene_open(&scene, &config, NULL, "train", 0, &err));
    FfpModel *model = ffp_model_new(&config.model, 1, &err);
    const size_t size = (size_t)model->count * sizeof(real);
    FfpTrainStep *stepper = ffp_train_step_new(&config, NULL);
    FfpLosses plain, polished;
    real *grad[2] = {ffp_alloc(1, size), ffp_alloc(1, size)};
    config.polish_share = 0;
    assert_true(ffp_train_step_loss(stepper, model, &scene, 0, &plain, grad[0], &err));
    config.polish_share = 1;
    config.polish_steps = 16;
    assert_true(ffp_train_step_loss(stepper, model, &scene, 0, &polished, grad[1], &err));
    assert_true(plain.seconds[FFP_PHASE_POLISH] == 0 && polished.seconds[FFP_PHASE_POLISH] > 0);
    assert_true(polished.term[FFP_TERM_L1] < 0.9 * plain.term[FFP_TERM_L1]);
    assert_true(memcmp(grad[0], grad[1], size) != 0);
    ffp_free(grad[0]), ffp_free(grad[1]);
    ffp_train_step_free(stepper);
    ffp_model_free(model);
    ffp_scene_close(&scene);
}

// --- Names. ---

// Checks the checkpoint's record of the initial weights, whose file has this name.
static void assert_origin(const char *name, const char *begin) {
    FfpError err = {0};
    FfpTrainConfig config;
    FfpAdam adam;
    FfpModelConfig tiny;
    char initial[FFP_PATH_MAX], origin[FFP_ORIGIN_MAX], command[128];
    snprintf(initial, sizeof initial, "%s", in_scratch(name));
    assert_true(ffp_model_preset(&tiny, "tiny"));
    FfpModel *model = ffp_model_new(&tiny, 1, &err);
    if (!ffp_model_write(model, initial, false, NULL, 0, &err)) fail_msg("%s", err.text);
    ffp_model_free(model);
    assert_true(ffp_write_file(in_scratch("config.json"), tiny_run, strlen(tiny_run), NULL));
    const FfpTrainRun options = {
        .out = in_scratch("named"), .config = in_scratch("config.json"), .initial = initial, .steps = 1};
    if (!ffp_train_run(&options, &err)) fail_msg("%s", err.text);
    model = ffp_checkpoint_read(in_scratch("named/checkpoint.safetensors"), &adam, &config, origin, &err);
    if (!model) fail_msg("%s", err.text);
    if (strncmp(origin, begin, strlen(begin)) != 0) fail_msg("'%s' is not '%s'", origin, begin);
    ffp_adam_free(&adam);
    ffp_model_free(model);
    snprintf(command, sizeof command, "rm -rf -- '%s/named'", scratch);
    assert_int_equal(system(command), 0);
}

// A checkpoint can be written whatever they are called.
static void test_weights_of_any_name(void **state) {
    (void)state;
    assert_origin("f\xfcr.safetensors", "weights: ");
#define NINE "123456789"
    assert_origin(NINE "-" NINE "-" NINE "-" NINE "-" NINE "-" NINE "\xc3\xbc.safetensors",
                  NINE "-" NINE "-" NINE "-" NINE "-" NINE "-" NINE ": ");
}

// --- Metrics. ---

// Weights that predict something, but are so large that their gradient is not finite.
static void write_absurd_weights(const char *path) {
    FfpError err = {0};
    FfpModelConfig config;
    assert_true(ffp_model_preset(&config, "tiny"));
    FfpModel *model = ffp_model_new(&config, 1, &err);
    for (int64_t i = 0; i < model->count; i++) model->values[i] *= 200;
    if (!ffp_model_write(model, path, true, NULL, 0, &err)) fail_msg("%s", err.text);
    ffp_model_free(model);
}

// Such a step is skipped, and its line says so in JSON that can be read.
static void test_a_gradient_that_is_no_number(void **state) {
    (void)state;
    FfpError err = {0};
    write_absurd_weights(in_scratch("absurd.safetensors"));
    assert_true(ffp_write_file(in_scratch("config.json"), tiny_run, strlen(tiny_run), NULL));
    const FfpTrainRun options = {.out = in_scratch("absurd"),
                                 .config = in_scratch("config.json"),
                                 .initial = in_scratch("absurd.safetensors"),
                                 .steps = 2};
    if (!ffp_train_run(&options, &err)) fail_msg("%s", err.text);
    FILE *file = fopen(in_scratch("absurd/metrics.jsonl"), "r");
    assert_non_null(file);
    for (int step = 0; step < 2; step++) {
        json_t *line = json_loadf(file, JSON_DISABLE_EOF_CHECK, NULL);
        assert_non_null(line);
        assert_int_equal(json_integer_value(json_object_get(line, "step")), step);
        assert_true(json_is_true(json_object_get(line, "skipped")));
        assert_true(json_is_null(json_object_get(line, "gradient_norm")));
        assert_true(json_is_number(json_object_get(line, "learning_rate")));
        json_decref(line);
    }
    fclose(file);
}

static void limit_files(rlim_t bytes) {
    struct rlimit limit;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &limit), 0);
    limit.rlim_cur = bytes;
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
}

static void test_metrics_that_cannot_be_written(void **state) {
    (void)state;
    FfpError err = {0};
    struct rlimit before;
    assert_true(ffp_write_file(in_scratch("config.json"), tiny_run, strlen(tiny_run), NULL));
    const FfpTrainRun options = {.out = in_scratch("full"), .config = in_scratch("config.json"), .steps = 2};
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    signal(SIGXFSZ, SIG_IGN); // the write fails instead
    limit_files(16);
    const bool ok = ffp_train_run(&options, &err);
    limit_files(before.rlim_cur);
    signal(SIGXFSZ, SIG_DFL);
    assert_false(ok);
    if (!strstr(err.text, "cannot write metrics.jsonl")) fail_msg("%s", err.text);
}

// --- Refusals, and learning. ---

static void test_refusals(void **state) {
    (void)state;
    FfpError err = {0};
    FfpTrainRun options = {.out = scratch, .steps = -1, .resume = true};
    assert_false(ffp_train_run(&options, &err));
    assert_non_null(strstr(err.text, "checkpoint.safetensors"));
    assert_true(ffp_write_file(in_scratch("checkpoint.safetensors"), "\x08\0\0\0\0\0\0\0{}      ", 16, NULL));
    assert_false(ffp_train_run(&options, &err));
    assert_non_null(strstr(err.text, "not a checkpoint"));
    assert_true(ffp_write_file(in_scratch("metrics.jsonl"), "", 0, NULL));
    options.resume = false;
    assert_false(ffp_train_run(&options, &err));
    assert_non_null(strstr(err.text, "resume it"));
}

// Of the input views' pictures that the network did not see, as a validation takes it.
static double scene_psnr(const FfpModel *model, const FfpScene *scene) {
    const FfpCapture *capture = &scene->inputs;
    const FfpRenderSettings settings =
        ffp_render_settings(ffp_model_is_paper_form(&model->config), model->config.samples);
    FfpRun *run = ffp_run_new(false);
    FfpViewPass *pass = ffp_view_pass_new(&settings);
    double sum = 0;
    int count = 0;
    assert_true(ffp_model_forward(model, run, capture, &scene->start, &scene->context, scene->active, NULL));
    for (int v = 0; v < capture->n_views; v++) {
        const FfpView *view = &capture->views[v];
        ffp_view_pass_draw(pass, &run->gaussians, &view->camera, &view->projector);
        FfpImage picture = ffp_view_pass_picture_new(pass);
        for (int p = 0; p < capture->n_patterns; p++) {
            if (p == capture->black || p == capture->white || p == scene->active) continue;
            FfpImage truth = ffp_image_copy(&view->images[p]);
            ffp_image_to_srgb(&truth);
            ffp_view_pass_shade(pass, capture->intensity, &scene->patterns[p], &picture);
            sum += ffp_psnr(&picture, &truth), count++;
            ffp_image_free(&truth);
        }
        ffp_image_free(&picture);
    }
    ffp_view_pass_free(pass);
    ffp_run_free(run);
    return sum / count;
}

// 34 dB on its own views within 500 steps.
static void test_overfit(void **state) {
    (void)state;
#ifdef FFP_SANITIZED
    printf("skipped: 500 steps take too long under the sanitizers\n");
    skip();
#endif
    static const char text[] =
        "{\"model\": \"tiny\", \"resolution\": 64, \"pool\": 1, \"reuse\": 1000000, \"views\": 8, "
        "\"targets\": 0, "
        "\"seed\": 1,"
        " \"lollipops\": 2, \"pattern_side\": 400, \"samples\": 8, \"supervised_inputs\": 4,"
        " \"supervised_targets\": 0, \"steps\": 500, \"warmup_steps\": 20, \"learning_rate\": 3e-3, \"l1\": "
        "1, \"ssim\": 0,"
        " \"distortion\": 0, \"normal_smooth\": 0, \"direct_t\": 0.1}";
    FfpTrainConfig config;
    FfpError err = {0};
    assert_true(ffp_train_config_parse(&config, text, "overfit", &err));
    FfpScene scene;
    assert_true(ffp_scene_open(&scene, &config, NULL, "train", 0, &err));
    FfpModel *model = ffp_model_new(&config.model, 1, &err);
    FfpAdam adam = ffp_adam_new(model);
    FfpTrainStep *stepper = ffp_train_step_new(&config, NULL);
    real *grad = ffp_alloc((size_t)model->count, sizeof *grad);
    double psnr = scene_psnr(model, &scene);
    const double before = psnr;
    int step = 0;
    while (psnr < 34 && step < 500) {
        FfpLosses losses;
        bool skipped;
        memset(grad, 0, (size_t)model->count * sizeof *grad);
        assert_true(ffp_train_step_loss(stepper, model, &scene, step, &losses, grad, &err));
        ffp_adam_update(&adam, model, grad, &config, &skipped);
        if (++step % 25 == 0) psnr = scene_psnr(model, &scene);
    }
    printf("overfit: %.2f dB before, %.2f dB after %d steps\n", before, psnr, step);
    assert_true(psnr >= 34);
    ffp_free(grad);
    ffp_train_step_free(stepper);
    ffp_adam_free(&adam);
    ffp_model_free(model);
    ffp_scene_close(&scene);
}

static FfpModel *weights_after(const char *name, const char *text) {
    char path[FFP_PATH_MAX];
    assert_true(ffp_write_file(in_scratch("config.json"), text, strlen(text), NULL));
    train(in_scratch(name), in_scratch("config.json"), 0, false);
    snprintf(path, sizeof path, "%s/weights.safetensors", in_scratch(name));
    FfpModel *model = ffp_model_read(path, NULL);
    assert_non_null(model);
    return model;
}

// With looks_only the other weights keep their bits, and the looks' move as far as they do without.
static void test_looks_only(void **state) {
    (void)state;
    static const char run[] =
        "{\"model\": {\"preset\": \"tiny\", \"looks\": 1}, \"resolution\": 64, \"pool\": 1, \"views\": 4, "
        "\"targets\": 1, \"lollipops\": 2, \"pattern_side\": 200, \"samples\": 1, \"ambient_rays\": 1, "
        "\"supervised_inputs\": 1, \"supervised_targets\": 1, \"warmup_steps\": 0, \"clip\": 1e6, \"ema\": "
        "0, "
        "\"validate_every\": 0, \"steps\": 1, \"learning_rate\": ";
    char text[sizeof run + 64];
    snprintf(text, sizeof text, "%s0}", run);
    FfpModel *before = weights_after("before", text);
    snprintf(text, sizeof text, "%s1e-3}", run);
    FfpModel *all = weights_after("all", text);
    snprintf(text, sizeof text, "%s1e-3, \"looks_only\": true}", run);
    FfpModel *looks = weights_after("looks", text);
    int moved = 0, kept = 0;
    for (int i = 0; i < before->n_parameters; i++) {
        const FfpParameter *p = &before->parameters[i];
        const bool look = strncmp(p->name, "look.", 5) == 0;
        const FfpModel *same = look ? all : before;
        assert_memory_equal(looks->values + p->offset, same->values + p->offset,
                            (size_t)p->count * sizeof(real));
        const bool differs =
            memcmp(all->values + p->offset, before->values + p->offset, (size_t)p->count * sizeof(real)) != 0;
        *(look ? &moved : &kept) += differs;
    }
    assert_true(moved > 0 && kept > 0);
    ffp_model_free(before);
    ffp_model_free(all);
    ffp_model_free(looks);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_resume),
        cmocka_unit_test(test_generators),
        cmocka_unit_test(test_training_looks_through_the_polish),
        cmocka_unit_test(test_weights_of_any_name),
        cmocka_unit_test(test_looks_only),
        cmocka_unit_test(test_a_gradient_that_is_no_number),
        cmocka_unit_test(test_metrics_that_cannot_be_written),
        cmocka_unit_test(test_overfit),
    };
    return cmocka_run_group_tests(tests, scratch_setup, scratch_teardown);
}
