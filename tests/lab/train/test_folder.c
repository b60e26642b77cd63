// Scenes from a folder are those made in memory, to the bit; and what such a folder may lack.
#include "lab/train/train.h"
#include "scratch.h"
#include "world/synth/dataset.h"

enum { SIDE = 32, SCENES = 3 };

// The common settings of the generator's preset `training` and this configuration, but for the resolution.
static FfpTrainConfig configuration(void) {
    FfpTrainConfig config = ffp_train_defaults();
    config.resolution = SIDE;
    return config;
}

static int setup(void **state) {
    if (scratch_setup(state) != 0) return -1;
    FfpError err = {0};
    const FfpDatasetSettings options = {.folder = in_scratch("made"),
                                        .split = "train",
                                        .preset = FFP_DATASET_TRAINING,
                                        .first = 5,
                                        .count = SCENES,
                                        .resolution = SIDE};
    if (ffp_dataset_write(&options, &err)) return 0;
    fprintf(stderr, "%s\n", err.text);
    return -1;
}

static void assert_same_image(const FfpImage *a, const FfpImage *b, const char *what) {
    assert_int_equal(a->width, b->width);
    assert_int_equal(a->height, b->height);
    assert_int_equal(a->channels, b->channels);
    const int count = a->width * a->height * a->channels;
    for (int i = 0; i < count; i++)
        if (a->data[i] != b->data[i])
            fail_msg("%s: value %d is %.9g and %.9g", what, i, (double)a->data[i], (double)b->data[i]);
}

static void assert_same_camera(const FfpCamera *a, const FfpCamera *b) {
    assert_int_equal(a->width, b->width);
    assert_int_equal(a->height, b->height);
    assert_true(a->fx == b->fx && a->fy == b->fy && a->cx == b->cx && a->cy == b->cy);
    for (int i = 0; i < 16; i++)
        if (a->pose[i] != b->pose[i])
            fail_msg("pose[%d] is %.9g and %.9g", i, (double)a->pose[i], (double)b->pose[i]);
}

static void assert_same_view(const FfpView *a, const FfpView *b, int patterns) {
    assert_string_equal(a->id, b->id);
    assert_same_camera(&a->camera, &b->camera);
    assert_same_camera(&a->projector, &b->projector);
    for (int p = 0; p < patterns; p++) assert_same_image(&a->images[p], &b->images[p], "picture");
    assert_same_image(&a->coverage, &b->coverage, "coverage");
    assert_same_image(&a->depth, &b->depth, "depth");
    assert_same_image(&a->normal, &b->normal, "normal");
    assert_same_image(&a->albedo, &b->albedo, "albedo");
    assert_same_image(&a->roughness, &b->roughness, "roughness");
    assert_same_image(&a->direct_white, &b->direct_white, "direct light");
}

static void assert_same_capture(const FfpCapture *a, const FfpCapture *b) {
    assert_string_equal(a->name, b->name);
    assert_int_equal(a->n_patterns, b->n_patterns);
    assert_int_equal(a->n_views, b->n_views);
    assert_int_equal(a->black, b->black);
    assert_int_equal(a->white, b->white);
    for (int c = 0; c < 3; c++) assert_true(a->intensity[c] == b->intensity[c]);
    for (int p = 0; p < a->n_patterns; p++) {
        assert_string_equal(a->patterns[p].name, b->patterns[p].name);
        assert_same_image(&a->patterns[p].image, &b->patterns[p].image, "pattern");
    }
    for (int v = 0; v < a->n_views; v++) assert_same_view(&a->views[v], &b->views[v], a->n_patterns);
}

// The whole and a part of it: fewer poses and patterns than there are.
static void folder_equals_memory(void **state) {
    (void)state;
    FfpError err = {0};
    FfpTrainConfig config = configuration();
    FfpSceneFolder folder;
    if (!ffp_scene_folder_open(&folder, in_scratch("made"), &err)) fail_msg("%s", err.text);
    assert_int_equal(folder.count, SCENES);
    for (int part = 0; part < 2; part++) {
        config.targets -= part, config.lollipops -= part;
        FfpSceneSpec spec = ffp_scene_defaults();
        spec.jitter = true, spec.resolution = SIDE;
        spec.targets = config.targets, spec.lollipops = config.lollipops;
        ffp_dataset_scene("train", 6, 0, &spec);
        FfpCapture made, read;
        if (!ffp_scene_make(&made, &spec, &err)) fail_msg("%s", err.text);
        if (!ffp_scene_folder_read(&read, &folder, "train_00006", &config, &err)) fail_msg("%s", err.text);
        assert_same_capture(&made, &read);
        ffp_capture_free(&made);
        ffp_capture_free(&read);
    }
    ffp_scene_folder_close(&folder);
}

// Every scene once a round, in another order each round, another for another seed; the same when asked again.
static void order_is_of_seed_and_number(void **state) {
    (void)state;
    static char names[5][FFP_SCENE_NAME_MAX] = {"a", "b", "c", "d", "e"};
    const FfpSceneFolder folder = {.count = 5, .names = names};
    int same_as_before = 0, same_seed = 0;
    for (int round = 0; round < 20; round++) {
        int seen[5] = {0};
        for (int i = 0; i < 5; i++) {
            const char *name = ffp_scene_folder_name(&folder, 7, 5 * round + i);
            seen[name[0] - 'a']++;
            assert_ptr_equal(name, ffp_scene_folder_name(&folder, 7, 5 * round + i));
            same_as_before += round > 0 && name == ffp_scene_folder_name(&folder, 7, 5 * (round - 1) + i);
            same_seed += name == ffp_scene_folder_name(&folder, 8, 5 * round + i);
        }
        for (int i = 0; i < 5; i++) assert_int_equal(seen[i], 1);
    }
    assert_true(same_as_before < 50 && same_seed < 50); // 19 and 20 by chance
}

static void only_training_scenes_count(void **state) {
    (void)state;
    FfpError err = {0};
    FfpSceneFolder folder;
    static const char *const others[] = {"mixed/test_00001", "mixed/all_00002", "mixed/.train_00003.part",
                                         "mixed/train_", "mixed/train_12x"};
    for (size_t i = 0; i < sizeof others / sizeof *others; i++)
        assert_true(ffp_make_folders(in_scratch(others[i]), &err));
    assert_false(ffp_scene_folder_open(&folder, in_scratch("mixed"), &err));
    assert_non_null(strstr(err.text, "holds no scene of the training split"));
    ffp_scene_folder_close(&folder);
    assert_true(ffp_make_folders(in_scratch("mixed/train_00004"), &err));
    assert_true(ffp_scene_folder_open(&folder, in_scratch("mixed"), &err));
    assert_int_equal(folder.count, 1);
    assert_string_equal(folder.names[0], "train_00004");
    ffp_scene_folder_close(&folder);
    assert_false(ffp_scene_folder_open(&folder, in_scratch("nowhere"), &err));
    assert_non_null(strstr(err.text, "cannot read the folder of scenes"));
    ffp_scene_folder_close(&folder);
}

static void refused(const FfpTrainConfig *config, const char *reason, const char *place) {
    FfpError err = {0};
    FfpSceneFolder folder;
    FfpCapture capture;
    assert_true(ffp_scene_folder_open(&folder, in_scratch("made"), &err));
    assert_false(ffp_scene_folder_read(&capture, &folder, "train_00005", config, &err));
    if (!strstr(err.text, reason) || !strstr(err.text, place))
        fail_msg("'%s' lacks '%s' or '%s'", err.text, reason, place);
    ffp_scene_folder_close(&folder);
}

static void what_is_asked_for_must_be_there(void **state) {
    (void)state;
    FfpTrainConfig config = configuration();
    config.views = 9;
    refused(&config, "holds 8 views; the configuration's views asks for 9", "train_00005/scene.json: views");
    config = configuration(), config.targets = 5;
    refused(&config, "holds 4 views; the configuration's targets asks for 5",
            "train_00005/targets/scene.json: views");
    config = configuration(), config.lollipops = 5;
    refused(&config, "4 patterns besides black and white; the configuration's lollipops asks for 5",
            "train_00005/scene.json: patterns");
    config = configuration(), config.resolution = 64;
    refused(&config, "pictures of 32 x 32; the configuration's resolution asks for 64",
            "train_00005/scene.json: view 'path_0_theta000', camera");
}

static void edit(const char *command) {
    char line[4096];
    snprintf(line, sizeof line, "cd %s/made/train_00005 && %s", scratch, command);
    assert_int_equal(system(line), 0);
}

// The last test: it takes the scene apart.
static void files_must_be_there(void **state) {
    (void)state;
    FfpTrainConfig config = configuration();
    config.truth_albedo = 1;
    edit("sed -i 's/\"albedo\"/\"no\"/' targets/scene.json");
    refused(&config, "a true map that the configuration uses is missing",
            "train_00005/targets/scene.json: view 'novel_00', albedo");
    config.truth_albedo = 0;
    edit("sed -i 's/\"lollipop_2\": \"novel/\"lollipop_1\": \"novel/' targets/scene.json");
    refused(&config, "broken JSON", "targets/scene.json"); // now twice in one object
    edit("sed -i '/\"lollipop_1\": /d' targets/scene.json");
    refused(&config, "a picture under a pattern is missing", "novel_00', images");
    edit("rm targets/novel_01_all_white.png");
    refused(&config, "no such file 'novel_01_all_white.png'",
            "targets/scene.json: views[1].images.all_white");
    edit("rm targets/scene.json");
    refused(&config, "the scene has no new poses; the configuration's targets asks for 4",
            "targets/scene.json");
    edit("rm scene.json");
    refused(&config, "no such file", "train_00005/scene.json");
}

// Trains for as many steps as there are scenes, each on its own.
static bool train_on_folder(const char *out, int side, int generators, FfpError *err) {
    static const char form[] = "{\"model\": \"tiny\", \"resolution\": %d, \"pool\": 1, \"reuse\": 1, "
                               "\"lollipops\": 2, \"scenes\": \"%s\","
                               " \"generators\": %d, \"steps\": %d, \"validate_every\": 0, \"log_every\": 1}";
    char text[sizeof form + FFP_PATH_MAX];
    snprintf(text, sizeof text, form, side, in_scratch("made"), generators, SCENES);
    assert_true(ffp_write_file(in_scratch("config.json"), text, strlen(text), NULL));
    const FfpTrainRun options = {.out = out, .config = in_scratch("config.json"), .steps = -1};
    return ffp_train_run(&options, err);
}

static FfpModel *trained(const char *out, int64_t steps) {
    char path[FFP_PATH_MAX], origin[FFP_ORIGIN_MAX];
    FfpAdam adam;
    FfpTrainConfig config;
    FfpError err = {0};
    assert_true(ffp_join_path(path, out, "checkpoint.safetensors"));
    FfpModel *model = ffp_checkpoint_read(path, &adam, &config, origin, &err);
    if (!model) fail_msg("%s", err.text);
    assert_int_equal(adam.step, steps);
    ffp_adam_free(&adam);
    return model;
}

static void training_reads_the_folder(void **state) {
    (void)state;
    FfpError err = {0};
    if (!train_on_folder(in_scratch("alone"), SIDE, 0, &err)) fail_msg("%s", err.text);
    if (!train_on_folder(in_scratch("helped"), SIDE, 2, &err)) fail_msg("%s", err.text);
    FfpModel *alone = trained(in_scratch("alone"), SCENES), *helped = trained(in_scratch("helped"), SCENES);
    assert_memory_equal(alone->values, helped->values, (size_t)alone->count * sizeof(real));
    ffp_model_free(alone);
    ffp_model_free(helped);
    assert_false(train_on_folder(in_scratch("larger"), 64, 1, &err));
    assert_non_null(strstr(err.text, "pictures of 32 x 32"));
    assert_false(ffp_is_file(in_scratch("larger/checkpoint.safetensors")));
}

// The scene of the last step is broken: the error names it, and the steps before are not lost.
static void a_bad_scene_ends_a_run(void **state) {
    (void)state;
    FfpError err = {0};
    FfpSceneFolder folder;
    char away[FFP_PATH_MAX], command[3 * FFP_PATH_MAX];
    assert_true(ffp_scene_folder_open(&folder, in_scratch("made"), &err));
    snprintf(away, sizeof away, "%s/made/%s", scratch, ffp_scene_folder_name(&folder, 1, SCENES - 1));
    ffp_scene_folder_close(&folder);
    snprintf(command, sizeof command, "mv %s/scene.json %s/away.json", away, away);
    assert_int_equal(system(command), 0);
    for (int generators = 0; generators < 3; generators += 2) {
        snprintf(command, sizeof command, "%s/bad%d", scratch, generators);
        assert_false(train_on_folder(command, SIDE, generators, &err));
        assert_non_null(strstr(err.text, away));
        ffp_model_free(trained(command, SCENES - 1));
    }
    snprintf(command, sizeof command, "mv %s/away.json %s/scene.json", away, away);
    assert_int_equal(system(command), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(folder_equals_memory),       cmocka_unit_test(order_is_of_seed_and_number),
        cmocka_unit_test(only_training_scenes_count), cmocka_unit_test(what_is_asked_for_must_be_there),
        cmocka_unit_test(training_reads_the_folder),  cmocka_unit_test(a_bad_scene_ends_a_run),
        cmocka_unit_test(files_must_be_there),
    };
    return cmocka_run_group_tests(tests, setup, scratch_teardown);
}
