// Scenes from a folder are those made in memory, to the bit; and what such a folder may lack.
#include "ffprocams.h"
#include "scratch.h"
#include "synth/dataset.h"
#include "train/train.h"

enum { SIDE = 32, SCENES = 3 };

// What the generator's preset `training` and this configuration have in common, but for the resolution.
static FfpTrainConfig configuration(void) {
    FfpTrainConfig config = ffp_train_defaults();
    config.resolution = SIDE;
    return config;
}

static int setup(void **state) {
    if (scratch_setup(state) != 0) return -1;
    FfpError err = {""};
    const FfpGeneration options = {.folder = in_scratch("made"),
                                   .split = "train",
                                   .preset = "training",
                                   .first = 5,
                                   .count = SCENES,
                                   .resolution = SIDE};
    if (ffp_generate(&options, &err)) return 0;
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
    FfpError err = {""};
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
        if (!ffp_scene_folder_read(&read, &folder, "train_00006", &config, SIDE, &err))
            fail_msg("%s", err.text);
        assert_same_capture(&made, &read);
        ffp_capture_free(&made);
        ffp_capture_free(&read);
    }
    ffp_scene_folder_close(&folder);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(folder_equals_memory),
    };
    return cmocka_run_group_tests(tests, setup, scratch_teardown);
}
