// Learning from captures: which photographs are learnt from and which are held out, that nothing but
// photographs is looked at, and that the weights that are kept are never worse than the first.
#include <math.h>
#include "core/base/alloc.h"
#include "lab/train/captures.h"
#include "scratch.h"
#include "world/synth/synth.h"

enum { SIDE = 24, VIEWS = 8, CAPTURES = 5 };

// A capture with everything that the generator knows of it.
static void write_capture(const char *folder, int mesh, int views, int lollipops) {
    FfpSceneSpec spec = ffp_scene_defaults();
    FfpCapture capture;
    FfpError err = {0};
    spec.mesh = mesh, spec.material = 3 * mesh, spec.seed = (uint64_t)mesh, spec.resolution = SIDE;
    spec.views = views, spec.targets = 0, spec.lollipops = lollipops, spec.pattern_side = 100,
    spec.samples = 4;
    if (!ffp_scene_make(&capture, &spec, &err) || !ffp_make_folders(folder, &err) ||
        !ffp_capture_write(&capture, folder, &err))
        fail_msg("%s", err.text);
    ffp_capture_free(&capture);
}

static int setup(void **state) {
    if (scratch_setup(state) != 0) return -1;
    for (int i = 0; i < CAPTURES; i++) {
        char name[32];
        snprintf(name, sizeof name, "captures/rig_%d", i);
        write_capture(in_scratch(name), 2 * i, VIEWS, 2);
    }
    return 0;
}

static FfpTrainConfig configuration(const char *captures) {
    FfpTrainConfig config = ffp_fine_tuning_defaults();
    assert_true(ffp_model_preset(&config.model, "tiny"));
    snprintf(config.captures, sizeof config.captures, "%s", captures);
    config.polish_steps = 2;
    return config;
}

static FfpCaptureSet *open_set(const FfpTrainConfig *config) {
    FfpError err = {0};
    FfpCaptureSet *set = ffp_captures_open(config, &err);
    if (!set) fail_msg("%s", err.text);
    return set;
}

static int count_views(const FfpScene *scene) {
    int in_both = 0;
    for (int i = scene->inputs.n_views; i < scene->capture.n_views; i++)
        for (int k = 0; k < scene->inputs.n_views; k++)
            in_both += strcmp(scene->capture.views[i].id, scene->capture.views[k].id) == 0;
    return in_both;
}

static void every_fourth_is_held_out(void **state) {
    (void)state;
    FfpError err = {0};
    const FfpTrainConfig config = configuration(in_scratch("captures"));
    FfpCaptureSet *set = open_set(&config);
    assert_int_equal(ffp_captures_count(set, false), CAPTURES - 1);
    assert_int_equal(ffp_captures_count(set, true), 1);
    FfpScene held;
    assert_true(ffp_captures_held_scene(&held, &config, set, 0, &err));
    assert_int_equal(held.inputs.n_views, 6);
    assert_int_equal(held.capture.n_views, VIEWS);
    assert_int_equal(count_views(&held), 0);
    int taught[VIEWS + 1] = {0};
    for (int64_t number = 0; number < 40; number++) {
        FfpScene scene, again;
        assert_true(ffp_captures_scene(&scene, &config, set, number, &err));
        assert_true(ffp_captures_scene(&again, &config, set, number, &err));
        assert_string_not_equal(scene.capture.name, held.capture.name);
        assert_int_equal(count_views(&scene), 0);
        taught[scene.capture.n_views - scene.inputs.n_views]++;
        for (int v = 0; v < scene.capture.n_views; v++) {
            assert_string_equal(scene.capture.views[v].id, again.capture.views[v].id);
            assert_null(scene.capture.views[v].depth.data);
            assert_null(scene.capture.views[v].albedo.data);
        }
        ffp_scene_close(&scene);
        ffp_scene_close(&again);
    }
    assert_true(taught[0] >= 4 && taught[2] >= 20 && taught[0] + taught[2] == 40);
    ffp_scene_close(&held);
    ffp_captures_close(set);
}

// Larger pictures are made smaller, and sides filled up to whole patches for the network alone.
static void pictures_have_the_size_asked_for(void **state) {
    (void)state;
    FfpError err = {0};
    FfpTrainConfig config = configuration(in_scratch("captures"));
    config.resolution = 20;
    FfpCaptureSet *set = open_set(&config);
    FfpScene scene;
    assert_true(ffp_captures_scene(&scene, &config, set, 0, &err));
    assert_int_equal(scene.capture.views[0].camera.width, 20);
    assert_int_equal(scene.capture.views[0].images[0].height, 20);
    assert_int_equal(scene.inputs.views[0].camera.width, 24);
    assert_int_equal(scene.start.width, 24);
    ffp_scene_close(&scene);
    ffp_captures_close(set);
}

static void refused(const FfpTrainConfig *config, const char *text) {
    FfpError err = {0};
    FfpCaptureSet *set = ffp_captures_open(config, &err);
    if (set) fail_msg("not refused: %s", text);
    if (!strstr(err.text, text)) fail_msg("'%s' does not say '%s'", err.text, text);
}

static void what_cannot_teach_is_refused(void **state) {
    (void)state;
    FfpError err = {0};
    FfpTrainConfig config = configuration(in_scratch("nowhere"));
    refused(&config, "cannot read the folder of captures");
    config = configuration(in_scratch("captures/rig_0"));
    refused(&config, "is a capture: name the folder that holds it");
    assert_true(ffp_make_folders(in_scratch("few"), &err));
    config = configuration(in_scratch("few"));
    refused(&config, "holds 0 captures");
    write_capture(in_scratch("few/a"), 1, 2, 1);
    refused(&config, "holds 1 captures");
    write_capture(in_scratch("few/b"), 1, 1, 1);
    refused(&config, "one view under one pattern");
    assert_true(ffp_write_file(in_scratch("few/b/scene.json"), "{}", 2, &err));
    refused(&config, "few/b/scene.json");
    assert_false(ffp_train_config_parse(&config, "{\"captures\": \"a\", \"scenes\": \"b\"}", "both", &err));
    assert_non_null(strstr(err.text, "cannot be combined"));
    assert_false(ffp_train_config_parse(&config, "{\"captures\": \"a\", \"free_share\": 0.5}", "both", &err));
}

// A run would go on with generated scenes when it is resumed, if its checkpoint lacked the path.
static void a_path_that_no_checkpoint_can_hold_is_refused(void **state) {
    (void)state;
    FfpError err = {0};
    const FfpTrainRun options = {
        .out = in_scratch("never"), .captures = in_scratch("f\xfcr"), .steps = -1, .stop_at = 0};
    assert_false(ffp_train_run(&options, &err));
    if (!strstr(err.text, "not UTF-8")) fail_msg("%s", err.text);
}

// --- Runs. ---

static void write_initial(const char *path) {
    FfpError err = {0};
    FfpModelConfig small;
    assert_true(ffp_model_preset(&small, "tiny"));
    FfpModel *model = ffp_model_new(&small, 3, &err);
    assert_true(ffp_model_write(model, path, false, NULL, 0, &err));
    ffp_model_free(model);
}

static double score_of(const char *weights) {
    FfpError err = {0};
    FfpTrainConfig config = configuration(in_scratch("captures"));
    FfpModel *model = ffp_model_read(weights, &err);
    if (!model) fail_msg("%s", err.text);
    config.model = model->config;
    FfpCaptureSet *set = open_set(&config);
    FfpHeldOut score;
    assert_true(ffp_captures_score(model, &config, set, &score, &err));
    assert_int_equal(score.photographs,
                     2 * 4 + 6); // two new poses under all, six views under the other lollipop
    ffp_captures_close(set);
    ffp_model_free(model);
    return score.polished;
}

static void run(const char *out, const char *text, int64_t stop_at, bool resume) {
    FfpError err = {0};
    char folder[FFP_PATH_MAX];
    snprintf(folder, sizeof folder, "%s", out); // in_scratch is asked for more
    assert_true(ffp_write_file(in_scratch("run.json"), text, strlen(text), &err));
    const FfpTrainRun options = {.out = folder,
                                 .captures = resume ? NULL : in_scratch("captures"),
                                 .config = resume ? NULL : in_scratch("run.json"),
                                 .initial = resume ? NULL : in_scratch("initial.safetensors"),
                                 .steps = -1,
                                 .stop_at = stop_at,
                                 .resume = resume};
    if (!ffp_train_run(&options, &err)) fail_msg("%s", err.text);
}

#define RUN(rate)                                                                                            \
    "{\"steps\": 12, \"validate_every\": 4, \"warmup_steps\": 1, \"polish_steps\": 2, "                      \
    "\"learning_rate\": " rate "}"

static void weights_are_never_worse_than_the_first(void **state) {
    (void)state;
    write_initial(in_scratch("initial.safetensors"));
    run(in_scratch("good"), RUN("3e-3"), 0, false);
    run(in_scratch("bad"), RUN("0.9"), 0, false);
    const double before = score_of(in_scratch("initial.safetensors")),
                 good = score_of(in_scratch("good/weights.safetensors")),
                 bad = score_of(in_scratch("bad/weights.safetensors"));
    print_message("held out: %.2f dB before, %.2f after, %.2f at an absurd rate\n", before, good, bad);
    assert_true(good > before + 0.1);
    assert_true(bad >= before);
}

static void a_stopped_run_goes_on_with_the_same_bits(void **state) {
    (void)state;
    FfpError err = {0};
    run(in_scratch("parts"), RUN("3e-3"), 6, false);
    run(in_scratch("parts"), "", 0, true);
    char *a, *b;
    size_t n, m;
    assert_true(ffp_read_file(in_scratch("good/checkpoint.safetensors"), 1 << 26, &a, &n, &err));
    assert_true(ffp_read_file(in_scratch("parts/checkpoint.safetensors"), 1 << 26, &b, &m, &err));
    assert_int_equal(n, m);
    assert_memory_equal(a, b, n);
    ffp_free(a);
    ffp_free(b);
    assert_true(fabs(score_of(in_scratch("parts/weights.safetensors")) -
                     score_of(in_scratch("good/weights.safetensors"))) < 1e-6);
}

// The steps whose weights have a score, as the metrics of a run say.
static void assert_scored(const char *metrics, const char *steps) {
    FfpError err = {0};
    char *text, scored[256] = "";
    size_t size;
    if (!ffp_read_text(metrics, 1 << 20, &text, &size, &err)) fail_msg("%s", err.text);
    for (char *line = text, *rest; line && *line; line = rest) {
        rest = strchr(line, '\n');
        if (rest) *rest++ = 0;
        int step;
        const size_t length = strlen(scored);
        if (strstr(line, "\"held_out\":") && sscanf(line, "{\"step\":%d,", &step) == 1)
            snprintf(scored + length, sizeof scored - length, "%d ", step);
    }
    ffp_free(text);
    assert_string_equal(scored, steps);
}

#define SELDOM(rate, every, patience)                                                                        \
    "{\"steps\": 12, \"validate_every\": " every ", \"patience\": " patience ", \"warmup_steps\": 1, "       \
    "\"polish_steps\": 2, \"learning_rate\": " rate "}"

// However a run ends: nothing that was learnt goes without a score, by which weights are kept.
static void the_last_weights_are_scored(void **state) {
    (void)state;
    run(in_scratch("seldom"), SELDOM("3e-3", "8", "0"), 6, false);
    assert_scored(in_scratch("seldom/metrics.jsonl"), "0 6 ");
    const double before = score_of(in_scratch("initial.safetensors")),
                 after = score_of(in_scratch("seldom/weights.safetensors"));
    assert_true(after > before);
    run(in_scratch("seldom"), "", 0, true);
    assert_scored(in_scratch("seldom/metrics.jsonl"), "0 6 8 12 ");
    run(in_scratch("patient"), SELDOM("0.9", "4", "6"), 0, false);
    assert_scored(in_scratch("patient/metrics.jsonl"), "0 4 8 ");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_fourth_is_held_out),
        cmocka_unit_test(pictures_have_the_size_asked_for),
        cmocka_unit_test(what_cannot_teach_is_refused),
        cmocka_unit_test(a_path_that_no_checkpoint_can_hold_is_refused),
        cmocka_unit_test(weights_are_never_worse_than_the_first),
        cmocka_unit_test(a_stopped_run_goes_on_with_the_same_bits),
        cmocka_unit_test(the_last_weights_are_scored),
    };
    return cmocka_run_group_tests(tests, setup, scratch_teardown);
}
