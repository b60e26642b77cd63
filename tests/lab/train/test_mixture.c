// Training on scenes of different kinds: number of input views, rig and size are drawn for each scene.
#include <math.h>
#include "core/base/alloc.h"
#include "lab/train/train.h"
#include "scratch.h"

static FfpTrainConfig configuration(const char *fields) {
    static const char form[] = "{\"model\": \"tiny\", \"resolution\": 16, \"views\": 6, \"targets\": 1,"
                               " \"supervised_targets\": 1, \"lollipops\": 2, \"pattern_side\": 64,"
                               " \"samples\": 1, \"ambient_rays\": 1%s%s}";
    char text[1024];
    FfpTrainConfig config;
    FfpError err = {0};
    snprintf(text, sizeof text, form, fields[0] ? ", " : "", fields);
    if (!ffp_train_config_parse(&config, text, "test", &err)) fail_msg("%s", err.text);
    return config;
}

static FfpScene open_scene(const FfpTrainConfig *config, const char *split, int64_t number) {
    FfpScene scene;
    FfpError err = {0};
    if (!ffp_scene_open(&scene, config, NULL, split, number, &err)) fail_msg("%s", err.text);
    return scene;
}

static bool is_free(const FfpScene *scene) {
    return strncmp(scene->capture.views[0].id, "free_", 5) == 0;
}

static bool same_image(const FfpImage *a, const FfpImage *b) {
    return a->width == b->width && a->height == b->height &&
           memcmp(a->data, b->data, (size_t)a->width * (size_t)a->height * 3 * sizeof(real)) == 0;
}

static bool same_scene(const FfpScene *a, const FfpScene *b) {
    bool same = a->capture.n_views == b->capture.n_views && a->inputs.n_views == b->inputs.n_views;
    for (int v = 0; same && v < a->capture.n_views; v++) {
        const FfpView *x = &a->capture.views[v], *y = &b->capture.views[v];
        same = memcmp(&x->camera, &y->camera, sizeof x->camera) == 0 &&
               memcmp(&x->projector, &y->projector, sizeof x->projector) == 0;
        for (int p = 0; same && p < a->capture.n_patterns; p++)
            same = same_image(&x->images[p], &y->images[p]);
    }
    return same;
}

static bool same_with(const char *fields_a, const char *fields_b, const char *split, int64_t number) {
    const FfpTrainConfig a = configuration(fields_a), b = configuration(fields_b);
    FfpScene x = open_scene(&a, split, number), y = open_scene(&b, split, number);
    const bool same = same_scene(&x, &y);
    ffp_scene_close(&x);
    ffp_scene_close(&y);
    return same;
}

static const char mixed[] = "\"views_least\": 1, \"free_share\": 0.5, \"large_share\": 0.3,"
                            " \"large_resolution\": 24";

static void every_kind_comes(void **state) {
    (void)state;
    const FfpTrainConfig config = configuration(mixed);
    int views[7] = {0}, unbound = 0, large = 0;
    for (int64_t number = 0; number < 40; number++) {
        FfpScene scene = open_scene(&config, "train", number);
        assert_in_range(scene.inputs.n_views, 1, 6);
        assert_int_equal(scene.capture.n_views, scene.inputs.n_views + 1);
        views[scene.inputs.n_views]++;
        unbound += is_free(&scene);
        const int side = scene.capture.views[0].camera.width;
        assert_true(side == 16 || side == 24);
        large += side == 24;
        ffp_scene_close(&scene);
    }
    for (int n = 1; n <= 6; n++) assert_true(views[n] > 0);
    assert_in_range(unbound, 12, 28);
    assert_in_range(large, 5, 20);
}

static void objects_and_patterns_stay(void **state) {
    (void)state;
    const FfpTrainConfig config = configuration(mixed), plain = configuration("");
    for (int64_t number = 0; number < TIMES(6, 2); number++) {
        FfpScene scene = open_scene(&config, "train", number), usual = open_scene(&plain, "train", number);
        assert_string_equal(scene.capture.name, usual.capture.name);
        for (int p = 0; p < usual.capture.n_patterns; p++)
            assert_true(same_image(&scene.capture.patterns[p].image, &usual.capture.patterns[p].image));
        ffp_scene_close(&scene);
        ffp_scene_close(&usual);
    }
}

static void scenes_follow_from_seed_and_number(void **state) {
    (void)state;
    for (int64_t number = 0; number < TIMES(6, 2); number++) {
        assert_true(same_with(mixed, mixed, "train", number));
        assert_true(same_with("", mixed, "validation", number));
        // shares that choose what there is anyway
        assert_true(same_with("", "\"views_least\": 6, \"large_share\": 1, \"large_resolution\": 16", "train",
                              number));
    }
    assert_false(same_with("", "\"free_share\": 1", "train", 0));
}

// Free rigs in validation: the same object and new poses, as many views. Scored beside the others, which stay
// as they are.
static void validation_sees_free_rigs(void **state) {
    (void)state;
    const FfpTrainConfig plain = configuration("\"validation_scenes\": 2, \"polish_steps\": 20"),
                         config = configuration("\"validation_scenes\": 2, \"polish_steps\": 20, "
                                                "\"free_share\": 0.5, \"views_least\": 2");
    FfpError err = {0};
    FfpScene bound = open_scene(&config, "validation", 1), unbound;
    assert_true(ffp_scene_open_free(&unbound, &config, 1, &err));
    assert_true(is_free(&unbound) && !is_free(&bound));
    assert_string_equal(bound.capture.name, unbound.capture.name);
    assert_int_equal(unbound.inputs.n_views, 6);
    assert_true(same_image(&bound.capture.views[6].images[1], &unbound.capture.views[6].images[1]));
    ffp_scene_close(&bound);
    ffp_scene_close(&unbound);

    FfpModel *model = ffp_model_new(&config.model, 1, &err);
    FfpValidation without, with;
    assert_true(ffp_validate(model, &plain, NULL, &without, &err));
    assert_true(ffp_validate(model, &config, NULL, &with, &err));
    assert_true(without.free_rendering == 0 && without.polished_free_novel_pose == 0);
    assert_true(with.rendering == without.rendering && with.novel_pose == without.novel_pose);
    assert_true(with.polished_rendering == without.polished_rendering);
    assert_true(with.free_rendering > 5 && with.free_novel_pose > 5 && with.free_rendering != with.rendering);
    assert_true(with.polished_free_rendering > with.free_rendering + 1 && with.polished_free_novel_pose > 5);
    ffp_model_free(model);
}

static const char run[] =
    "{\"model\": \"tiny\", \"resolution\": 32, \"pool\": 2, \"reuse\": 1, \"views\": 10, \"views_least\": 2,"
    " \"free_share\": 0.5, \"large_share\": 0.3, \"large_resolution\": 48, \"targets\": 1,"
    " \"lollipops\": 2, \"pattern_side\": 200, \"samples\": 1, \"ambient_rays\": 1,"
    " \"supervised_inputs\": 3, \"supervised_targets\": 1, \"steps\": 8, \"warmup_steps\": 2,"
    " \"polish_share\": 0.3, \"polish_steps\": 3, \"validate_every\": 0, \"log_every\": 1,"
    " \"generators\": %d}";

static void train(const char *out, const char *config, int64_t stop_at) {
    FfpError err = {0};
    const FfpTrainRun options = {
        .out = out, .config = config, .steps = -1, .stop_at = stop_at, .resume = !config};
    if (!ffp_train_run(&options, &err)) fail_msg("%s", err.text);
}

static FfpModel *trained(const char *out) {
    char path[FFP_PATH_MAX], origin[FFP_ORIGIN_MAX];
    FfpAdam adam;
    FfpTrainConfig config;
    FfpError err = {0};
    assert_true(ffp_join_path(path, out, "checkpoint.safetensors"));
    FfpModel *model = ffp_checkpoint_read(path, &adam, &config, origin, &err);
    if (!model) fail_msg("%s", err.text);
    assert_int_equal(adam.step, 8);
    ffp_adam_free(&adam);
    return model;
}

// Eight steps on eight scenes: none is skipped, as one with a loss that is not finite would be.
static void assert_all_counted(const char *out) {
    char path[FFP_PATH_MAX], *text;
    size_t size;
    int lines = 0;
    assert_true(ffp_join_path(path, out, "metrics.jsonl"));
    assert_true(ffp_read_file(path, 1 << 20, &text, &size, NULL));
    assert_null(strstr(text, "\"skipped\":true"));
    for (size_t i = 0; i < size; i++) lines += text[i] == '\n';
    assert_int_equal(lines, 8);
    ffp_free(text);
}

// Whoever makes the scenes and wherever the run was stopped.
static void a_run_repeats_its_bits(void **state) {
    (void)state;
    char text[sizeof run + 16];
    const char *alone = in_scratch("alone"), *helped = in_scratch("helped"),
               *config = in_scratch("config.json");
    snprintf(text, sizeof text, run, 0);
    assert_true(ffp_write_file(config, text, strlen(text), NULL));
    train(alone, config, 0);
    assert_all_counted(alone);
    snprintf(text, sizeof text, run, 2);
    assert_true(ffp_write_file(config, text, strlen(text), NULL));
    train(helped, config, 5);
    train(helped, NULL, 0);
    FfpModel *a = trained(alone), *b = trained(helped);
    for (int64_t i = 0; i < a->count; i++) assert_true(isfinite(a->values[i]));
    assert_memory_equal(a->values, b->values, (size_t)a->count * sizeof(real));
    ffp_model_free(a);
    ffp_model_free(b);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_kind_comes),
        cmocka_unit_test(objects_and_patterns_stay),
        cmocka_unit_test(scenes_follow_from_seed_and_number),
        cmocka_unit_test(validation_sees_free_rigs),
        cmocka_unit_test(a_run_repeats_its_bits),
    };
    return cmocka_run_group_tests(tests, scratch_setup, scratch_teardown);
}
