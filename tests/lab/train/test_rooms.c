// Rooms to learn from: that they are a share of the scenes, reconstructed from their photographs and
// supervised by clean pictures alone, and what such a folder may lack.
#include <math.h>
#include <stdlib.h>
#include "core/base/alloc.h"
#include "lab/train/captures.h"
#include "scratch.h"
#include "world/synth/synth.h"

enum { SIDE = 24, STOPS = 4, CLEAN = 3 };

// A room: photographs without red, and `clean` true pictures at other poses; -1: one that lacks white.
static void write_room(const char *folder, int mesh, int wanted) {
    const int clean = abs(wanted);
    FfpSceneSpec spec = ffp_scene_defaults();
    FfpCapture made;
    FfpError err = {0};
    char inner[FFP_PATH_MAX];
    spec.mesh = mesh, spec.material = 3 * mesh, spec.resolution = SIDE, spec.views = STOPS;
    spec.targets = clean, spec.lollipops = 2, spec.pattern_side = 100, spec.samples = 4;
    assert_true(ffp_scene_make(&made, &spec, &err) && ffp_join_path(inner, folder, "targets"));
    for (int v = 0; v < STOPS; v++)
        for (int p = 0; p < made.n_patterns; p++)
            for (int i = 0; i < SIDE * SIDE; i++) made.views[v].images[p].data[3 * i] = 0;
    FfpCapture photographs = made, truth = made;
    photographs.n_views = STOPS, truth.n_views = clean, truth.views += STOPS;
    if (wanted < 0) ffp_image_free(&truth.views[0].images[truth.white]);
    if (!ffp_make_folders(inner, &err) || !ffp_capture_write(&photographs, folder, &err) ||
        !ffp_capture_write(&truth, inner, &err))
        fail_msg("%s", err.text);
    ffp_capture_free(&made);
}

static FfpTrainConfig with_rooms(const char *rooms) {
    FfpTrainConfig config = ffp_train_defaults();
    assert_true(ffp_model_preset(&config.model, "tiny"));
    snprintf(config.rooms, sizeof config.rooms, "%s", rooms);
    config.room_share = 0.5, config.resolution = SIDE;
    return config;
}

static double red_of(const FfpScene *scene, int view, int pattern) {
    double sum = 0;
    for (int i = 0; i < SIDE * SIDE; i++)
        sum += (double)scene->capture.views[view].images[pattern].data[3 * i];
    return sum;
}

static double loss_of(const FfpScene *scene, const FfpTrainConfig *config) {
    FfpError err = {0};
    FfpLosses losses;
    FfpModel *model = ffp_model_new(&config->model, 1, &err);
    FfpTrainStep *step = ffp_train_step_new(config, NULL);
    real *grad = ffp_alloc((size_t)model->count, sizeof *grad);
    if (!ffp_train_step_loss(step, model, scene, 0, &losses, grad, &err)) fail_msg("%s", err.text);
    assert_true(losses.term[FFP_TERM_DEPTH] == 0 && losses.term[FFP_TERM_DIRECT_T] == 0);
    ffp_free(grad);
    ffp_train_step_free(step);
    ffp_model_free(model);
    return losses.total;
}

static void blacken(FfpScene *scene, int view) {
    for (int p = 0; p < scene->capture.n_patterns; p++)
        memset(scene->capture.views[view].images[p].data, 0, sizeof(real) * 3 * SIDE * SIDE);
}

static void rooms_are_supervised_by_clean_pictures_alone(void **state) {
    (void)state;
    FfpError err = {0};
    for (int i = 0; i < 2; i++) write_room(in_scratch(i ? "rooms/b" : "rooms/a"), 2 * i, CLEAN);
    const FfpTrainConfig config = with_rooms(in_scratch("rooms"));
    FfpCaptureSet *set = ffp_rooms_open(&config, &err);
    if (!set) fail_msg("%s", err.text);
    assert_int_equal(ffp_captures_count(set, false), 2);
    FfpScene scene, next;
    if (!ffp_rooms_scene(&scene, &config, set, 0, &err)) fail_msg("%s", err.text);
    assert_true(ffp_rooms_scene(&next, &config, set, 1, &err));
    assert_string_not_equal(scene.capture.name, next.capture.name);
    assert_int_equal(scene.inputs.n_views, STOPS);
    assert_int_equal(scene.capture.n_views, STOPS + CLEAN);
    for (int v = 0; v < STOPS + CLEAN; v++) {
        assert_true((red_of(&scene, v, scene.capture.white) > 1) == (v >= STOPS));
        assert_null(scene.capture.views[v].depth.data);
    }
    const double before = loss_of(&scene, &config);
    for (int v = 0; v < STOPS; v++) blacken(&scene, v);
    assert_true(loss_of(&scene, &config) == before);
    for (int v = STOPS; v < STOPS + CLEAN; v++) blacken(&scene, v);
    assert_true(fabs(loss_of(&scene, &config) - before) > 1e-3);
    ffp_scene_close(&scene);
    ffp_scene_close(&next);
    ffp_captures_close(set);
}

static void rooms_are_a_share_of_the_scenes(void **state) {
    (void)state;
    FfpError err = {0};
    atomic_bool stop = false;
    FfpTrainConfig config = with_rooms(in_scratch("rooms"));
    config.views = STOPS, config.targets = 1, config.lollipops = 1, config.pattern_side = 100;
    config.pool = 1, config.reuse = 1;
    FfpCaptureSet *set = ffp_rooms_open(&config, &err);
    const FfpSceneOrigin origin = {.rooms = set};
    FfpStream *stream = ffp_stream_new(&config, &origin, (FfpRank){0, 1}, 0, 16, &stop, &err);
    int rooms = 0;
    for (int64_t draw = 0; draw < 16; draw++) {
        const FfpScene *scene;
        bool fresh;
        if (!ffp_stream_scene(stream, draw, &scene, &fresh, &err)) fail_msg("%s", err.text);
        assert_true(scene->targets_only == ffp_is_room(&config, draw));
        assert_int_equal(scene->capture.n_views, scene->targets_only ? STOPS + CLEAN : STOPS + 1);
        rooms += scene->targets_only;
    }
    assert_true(rooms > 3 && rooms < 13);
    config.room_share = 0;
    for (int64_t number = 0; number < 40; number++) assert_false(ffp_is_room(&config, number));
    ffp_stream_free(stream);
    ffp_captures_close(set);
}

static void no_rooms(const char *folder, const char *text) {
    FfpError err = {0};
    const FfpTrainConfig config = with_rooms(folder);
    if (ffp_rooms_open(&config, &err)) fail_msg("not refused: %s", text);
    if (!strstr(err.text, text)) fail_msg("'%s' does not say '%s'", err.text, text);
}

static void rooms_that_cannot_teach_are_refused(void **state) {
    (void)state;
    FfpError err = {0};
    no_rooms(in_scratch("nowhere"), "cannot read the folder of rooms");
    no_rooms(in_scratch("rooms/a"), "is a room: name the folder");
    assert_true(ffp_make_folders(in_scratch("none"), &err));
    no_rooms(in_scratch("none"), "holds no rooms");
    write_room(in_scratch("bare/a"), 1, 1);
    assert_int_equal(unlink(in_scratch("bare/a/targets/scene.json")), 0);
    no_rooms(in_scratch("bare"), "no clean pictures");
    write_room(in_scratch("torn/a"), 1, 1);
    assert_true(ffp_write_file(in_scratch("torn/a/targets/scene.json"), "{}", 2, &err));
    no_rooms(in_scratch("torn"), "torn/a/targets/scene.json");
    write_room(in_scratch("many/a"), 1, FFP_TRAIN_VIEWS_MAX + 1);
    no_rooms(in_scratch("many"), "holds too many views");
    write_room(in_scratch("dark/a"), 1, -1);
    no_rooms(in_scratch("dark"), "no picture under white");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rooms_are_supervised_by_clean_pictures_alone),
        cmocka_unit_test(rooms_are_a_share_of_the_scenes),
        cmocka_unit_test(rooms_that_cannot_teach_are_refused),
    };
    return cmocka_run_group_tests(tests, scratch_setup, scratch_teardown);
}
