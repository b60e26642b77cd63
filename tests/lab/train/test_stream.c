// Which scene a step gets does not depend on who makes it, nor on where the run began.
// Labels: threads
#include "core/base/call.h"
#include "lab/train/train.h"
#include "scratch.h"

enum { STEPS = 12 };
static const FfpSceneOrigin generated = {0};
static atomic_bool stop;

static FfpTrainConfig configuration(const char *fields) {
    static const char form[] =
        "{\"views\": 2, \"targets\": 1, \"supervised_inputs\": 1, \"supervised_targets\": 1,"
        " \"lollipops\": 1, \"pattern_side\": 64, \"samples\": 1, \"ambient_rays\": 1, %s}";
    char text[1024];
    FfpTrainConfig config;
    FfpError err = {0};
    snprintf(text, sizeof text, form, fields);
    if (!ffp_train_config_parse(&config, text, "test", &err)) fail_msg("%s", err.text);
    return config;
}

// FNV-1a of bytes.
static uint64_t hash(uint64_t sum, const void *data, size_t size) {
    const unsigned char *bytes = data;
    for (size_t i = 0; i < size; i++) sum = (sum ^ bytes[i]) * 0x100000001b3ULL;
    return sum;
}

static uint64_t hash_image(uint64_t sum, const FfpImage *image) {
    return hash(sum, image->data,
                sizeof(real) * (size_t)image->width * (size_t)image->height * (size_t)image->channels);
}

// Of all that a step reads: poses, pictures, truth, the start's maps.
static uint64_t hash_scene(const FfpScene *scene) {
    const FfpCapture *capture = &scene->capture;
    uint64_t sum = hash(0xcbf29ce484222325ULL, capture->intensity, sizeof capture->intensity);
    for (int v = 0; v < capture->n_views; v++) {
        const FfpView *view = &capture->views[v];
        sum = hash(sum, &view->camera, sizeof view->camera);
        sum = hash(sum, &view->projector, sizeof view->projector);
        for (int p = 0; p < capture->n_patterns; p++) sum = hash_image(sum, &view->images[p]);
        const FfpImage *const maps[] = {&view->coverage, &view->depth, &view->normal, &view->albedo,
                                        &view->roughness};
        for (size_t i = 0; i < sizeof maps / sizeof *maps; i++) sum = hash_image(sum, maps[i]);
    }
    const size_t pixels =
        (size_t)scene->inputs.n_views * (size_t)scene->start.width * (size_t)scene->start.height;
    const FfpInitialisation *s = &scene->start;
    sum = hash(sum, s->t, pixels * sizeof(real));
    return hash(sum, s->albedo, 3 * pixels * sizeof(real));
}

// The hash of every step's scene, in steps [first, STEPS).
static void walk(const FfpTrainConfig *config, int first, uint64_t sums[STEPS]) {
    FfpError err = {0};
    stop = false;
    FfpStream *stream = ffp_stream_new(config, &generated, (FfpRank){0, 1}, first, STEPS, &stop, &err);
    if (!stream) fail_msg("%s", err.text);
    for (int step = first; step < STEPS; step++) {
        const FfpScene *scene;
        bool fresh;
        if (!ffp_stream_scene(stream, step, &scene, &fresh, &err)) fail_msg("%s", err.text);
        assert_non_null(scene);
        sums[step] = hash_scene(scene);
        // the slot was seen last a round ago, in this run
        const int before = step - config->pool;
        assert_true(fresh == (before < first || sums[before] != sums[step]));
    }
    ffp_stream_free(stream);
}

// The same by opening the scene of every step by itself; only steps that share a number share a scene.
static void walk_plainly(const FfpTrainConfig *config, uint64_t sums[STEPS]) {
    FfpError err = {0};
    for (int step = 0; step < STEPS; step++) {
        const int64_t number = ffp_scene_number(config, step);
        int known = 0;
        while (known < step && ffp_scene_number(config, known) != number) known++;
        if (known < step) {
            sums[step] = sums[known];
            continue;
        }
        FfpScene scene;
        if (!ffp_scene_open(&scene, config, NULL, "train", number, &err)) fail_msg("%s", err.text);
        sums[step] = hash_scene(&scene);
        ffp_scene_close(&scene);
    }
}

static void compare(const char *fields) {
    static const int walks[][2] = {{0, 0}, {1, 4}, {3, 0}, {3, 7}}; // generators, first step
    FfpTrainConfig config = configuration(fields);
    uint64_t plain[STEPS], sums[STEPS];
    walk_plainly(&config, plain);
    assert_true(plain[0] != plain[STEPS - 1]);
    for (size_t i = 0; i < sizeof walks / sizeof *walks; i++) {
        config.generators = walks[i][0];
        walk(&config, walks[i][1], sums);
        for (int step = walks[i][1]; step < STEPS; step++)
            if (sums[step] != plain[step])
                fail_msg("%d generators, from step %d: step %d differs (%s)", walks[i][0], walks[i][1], step,
                         fields);
    }
}

static void threads_and_beginnings_do_not_matter(void **state) {
    (void)state;
    compare("\"pool\": 2, \"reuse\": 3, \"resolution\": 16");
    compare("\"pool\": 3, \"reuse\": 2, \"resolution\": 8, \"queue\": 1");
}

// The generator's own check fails, in a thread of the stream; the trainer's thread hears which scene it was.
static void an_error_names_the_scene(void **state) {
    (void)state;
    FfpTrainConfig config = configuration("\"pool\": 2, \"resolution\": 8, \"seed\": 3");
    config.samples = 0; // as no file can say it
    for (config.generators = 0; config.generators <= 2; config.generators++) {
        FfpError err = {0};
        const FfpScene *scene;
        bool fresh;
        FfpStream *stream = ffp_stream_new(&config, &generated, (FfpRank){0, 1}, 1, STEPS, &stop, &err);
        assert_false(ffp_stream_scene(stream, 1, &scene, &fresh, &err));
        assert_null(scene);
        if (!strstr(err.text, "scene 1 of the train split") || !strstr(err.text, "0 samples"))
            fail_msg("%s", err.text);
        ffp_stream_free(stream);
    }
}

static bool take_and_leave(void *argument, FfpError *err) {
    const FfpTrainConfig *config = argument;
    const FfpScene *scene;
    bool fresh;
    FfpStream *stream = ffp_stream_new(config, &generated, (FfpRank){0, 1}, 0, STEPS, &stop, err);
    if (!stream || !ffp_stream_scene(stream, 0, &scene, &fresh, err) || !scene) return false;
    ffp_no_memory(1);
    return true;
}

// Threads have made the scene, in calls that have ended: nobody but the stream gives it back when the
// trainer's call is left (the build with AddressSanitizer tells).
static void a_call_that_is_left_leaves_no_scene(void **state) {
    (void)state;
    FfpTrainConfig config = configuration("\"pool\": 2, \"resolution\": 8, \"queue\": 2");
    stop = false;
    for (config.generators = 0; config.generators <= 2; config.generators++) {
        FfpContext context = {0};
        FfpError err = {0};
        assert_false(ffp_call_run(&context, take_and_leave, &config, &err));
        assert_int_equal(err.code, FFP_ERROR_MEMORY);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(threads_and_beginnings_do_not_matter),
        cmocka_unit_test(an_error_names_the_scene),
        cmocka_unit_test(a_call_that_is_left_leaves_no_scene),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
