// From a capture to Gaussians, pictures, figures and a report, through the command line only.
#include <signal.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>
#include "core/gaussians/gaussians.h"
#include "lab/train/train.h"
#include "product/cli/program.h"
#include "product/cli/tiny.h"

#define SIDE 48
#define KILLS 16

static ProgramRun run;

static bool is_there(const char *format, ...) __attribute__((format(printf, 1, 2)));
static bool is_there(const char *format, ...) {
    char path[1024];
    va_list list;
    va_start(list, format);
    vsnprintf(path, sizeof path, format, list);
    va_end(list);
    return ffp_is_file(path);
}

static json_t *load_json(const char *name) {
    char path[256];
    snprintf(path, sizeof path, "%s/%s", scratch, name);
    json_t *root = json_load_file(path, 0, NULL);
    assert_non_null(root);
    return root;
}

static json_t *find_row(json_t *root, const char *protocol) {
    size_t i;
    json_t *row;
    json_array_foreach(json_object_get(root, "rows"), i, row) {
        if (strcmp(json_string_value(json_object_get(row, "protocol")), protocol) == 0) return row;
    }
    return NULL;
}

static int group_setup(void **state) {
    if (scratch_setup(state) != 0) return -1;
    char folder[128];
    snprintf(folder, sizeof folder, "%s/tiny", scratch);
    tiny_capture(folder, SIDE);
    assert_int_equal(
        run_format(&run, "reconstruct %s/tiny -o %s/tiny.ply --model none --polish 8", scratch, scratch), 0);
    assert_true(is_there("%s/tiny.ply", scratch));
    return 0;
}

static void test_info_tells_what_files_hold(void **state) {
    (void)state;
    assert_int_equal(run_format(&run, "info %s/tiny", scratch), 0);
    assert_non_null(strstr(run.out, "views        4"));
    assert_non_null(strstr(run.out, "reconstructs from lollipop_0; can add lollipop_1\n"));
    assert_int_equal(run_format(&run, "info %s/tiny/render_poses.json", scratch), 0);
    assert_non_null(strstr(run.out, "stripes"));
    assert_int_equal(run_format(&run, "info %s/tiny.ply", scratch), 0);
    assert_non_null(strstr(run.out, "Gaussians    "));
    assert_non_null(strstr(run.out, "opacity"));
}

// The picture's PSNR by its definition, from the files alone.
static double psnr_of_files(const char *prediction_path, const char *truth_path) {
    FfpImage prediction, truth;
    assert_true(ffp_image_read(&prediction, prediction_path, FFP_COLOUR_ENCODED, NULL));
    assert_true(ffp_image_read(&truth, truth_path, FFP_COLOUR_ENCODED, NULL));
    assert_int_equal(prediction.width, truth.width);
    double sum = 0;
    const int pixels = truth.width * truth.height;
    for (int i = 0; i < pixels; i++)
        for (int c = 0; c < 3; c++) {
            const double e = (double)prediction.data[4 * i + c] -
                             (double)truth.data[4 * i + c] * (double)truth.data[4 * i + 3];
            sum += e * e;
        }
    ffp_image_free(&prediction);
    ffp_image_free(&truth);
    return -10 * log10(sum / (3.0 * pixels));
}

static double psnr_in_scratch(const char *prediction, const char *truth) {
    const double psnr = psnr_of_files(in_scratch(prediction), in_scratch(truth));
    printf("%s, %s: %.2f dB\n", prediction, truth, psnr);
    return psnr;
}

// The middle of the ball, whose nearest point is 2.215 from the camera, which is where y is greatest, and a
// corner of the picture.
static void check_maps(void) {
    static const struct {
        const char *name;
        double middle[3], within;
    } maps[] = {{"opacity", {1, 1, 1}, 0.02},
                {"normal", {0.5, 1, 0.5}, 0.15},
                {"albedo", {0.797, 0.797, 0.797}, 0.05},   // 0.6 as sRGB
                {"ambient", {0.271, 0.271, 0.271}, 0.02}}; // 0.06
    const int middle = SIDE / 2 * SIDE + SIDE / 2;
    FfpImage map;
    assert_true(ffp_image_read_raw16(&map, in_scratch("some/view_1_depth.exr"), NULL, NULL));
    assert_true(fabs((double)map.data[middle] - 2.215) < 0.08 && map.data[0] == 0);
    ffp_image_free(&map);
    for (size_t i = 0; i < sizeof maps / sizeof *maps; i++) {
        char name[64];
        snprintf(name, sizeof name, "some/view_1_%s.png", maps[i].name);
        assert_true(ffp_image_read(&map, in_scratch(name), FFP_COLOUR_ENCODED, NULL));
        const real *at = map.data + (size_t)(4 * middle);
        printf("%s: %.3f %.3f %.3f\n", maps[i].name, (double)at[0], (double)at[1], (double)at[2]);
        for (int c = 0; c < 3; c++)
            assert_true(fabs((double)at[c] - maps[i].middle[c]) < maps[i].within && map.data[c] == 0);
        ffp_image_free(&map);
    }
}

static void test_render_writes_the_pictures_and_maps_it_is_asked_for(void **state) {
    (void)state;
    assert_int_equal(
        run_format(&run,
                   "render %s/tiny.ply --capture %s/tiny --view view_1 --pattern stripes --pattern "
                   "%s/tiny/novel_1_stripes.png "
                   "--maps -o %s/some",
                   scratch, scratch, scratch, scratch),
        0);
    static const char *const files[] = {"stripes.png", "novel_1_stripes.png", "depth.exr",
                                        "depth.png",   "opacity.png",         "normal.png",
                                        "albedo.png",  "roughness.png",       "ambient.png"};
    for (size_t i = 0; i < sizeof files / sizeof *files; i++)
        assert_true(is_there("%s/some/view_1_%s", scratch, files[i]));
    assert_false(is_there("%s/some/view_0_stripes.png", scratch));
    assert_int_equal(
        run_format(&run, "render %s/tiny.ply --capture %s/tiny --poses %s/tiny/targets.json -o %s/poses",
                   scratch, scratch, scratch, scratch),
        0);
    assert_true(is_there("%s/poses/novel_0_all_white.png", scratch));
    assert_true(is_there("%s/poses/novel_1_all_white.png", scratch));
    const double right = psnr_in_scratch("some/view_1_stripes.png", "tiny/view_1_stripes.png");
    assert_true(right > 22);
    assert_true(right > psnr_in_scratch("some/view_1_novel_1_stripes.png", "tiny/view_1_stripes.png") + 2);
    assert_true(psnr_in_scratch("poses/novel_0_all_white.png", "tiny/novel_0_all_white.png") > 20);
    check_maps();
}

// Camera, projector and pattern are those asked for: another projector would light the ball from elsewhere.
static void test_render_looks_from_where_it_is_told(void **state) {
    (void)state;
    FfpCamera camera, projector;
    tiny_aside(scratch, SIDE, &camera, &projector);
    assert_int_equal(
        run_format(&run,
                   "render %s/tiny.ply --capture %s/tiny --poses %s/aside.json --pattern stripes "
                   "--pattern lollipop_1 -o %s/aside",
                   scratch, scratch, scratch, scratch),
        0);
    const double right = psnr_in_scratch("aside/aside_stripes.png", "aside.png");
    assert_true(right > 22);
    assert_true(right > psnr_in_scratch("aside/aside_lollipop_1.png", "aside.png") + 2);
    assert_true(right > psnr_in_scratch("some/view_1_stripes.png", "aside.png") + 2);
}

static double mean_psnr_of_files(const char *saved, const char *prefix, int views, int first, int last) {
    double sum = 0;
    for (int v = 0; v < views; v++)
        for (int p = first; p <= last; p++) {
            char prediction[512], truth[512];
            snprintf(prediction, sizeof prediction, "%s/%s/tiny/%s_%d_%s.png", scratch, saved, prefix, v,
                     tiny_patterns[p]);
            snprintf(truth, sizeof truth, "%s/tiny/%s_%d_%s.png", scratch, prefix, v, tiny_patterns[p]);
            sum += psnr_of_files(prediction, truth);
        }
    return sum / (views * (last - first + 1));
}

static void check_row(json_t *root, const char *protocol, int images, double psnr) {
    json_t *row = find_row(root, protocol);
    assert_non_null(row);
    assert_string_equal(json_string_value(json_object_get(row, "capture")), "tiny");
    assert_int_equal(json_integer_value(json_object_get(row, "images")), images);
    const double told = json_real_value(json_object_get(row, "psnr"));
    if (!(fabs(told - psnr) <= 0.02))
        printf("%s: told %.4f dB, the files say %.4f dB\n", protocol, told, psnr);
    assert_true(fabs(told - psnr) <= 0.02);
    assert_true(json_is_null(json_object_get(row, "lpips")));
    assert_true(json_is_null(json_object_get(row, "psnr_gloss"))); // no truth in these files
    const double ssim = json_real_value(json_object_get(row, "ssim"));
    assert_true(ssim > 0.3 && ssim <= 1);
    assert_true(json_real_value(json_object_get(row, "psnr_foreground")) < told); // the background is easy
    assert_true(json_real_value(json_object_get(row, "render_s")) > 0);
}

static void test_told_psnr_is_that_of_the_saved_pictures(void **state) {
    (void)state;
    assert_int_equal(
        run_format(&run,
                   "evaluate %s/tiny --model none --polish 8 --targets targets.json --save %s/saved --json "
                   "%s/new/folder/scores.json "
                   "--report %s/report.html "
                   "--show-pattern %s/tiny/patterns/stripes.png",
                   scratch, scratch, scratch, scratch, scratch),
        0);
    json_t *root = load_json("new/folder/scores.json");
    static const char *const order[] = {"novel_pattern", "novel_pose", "unseen", "rendering", "given"};
    assert_int_equal(json_array_size(json_object_get(root, "rows")), 5);
    assert_int_equal(json_array_size(json_object_get(root, "means")), 5);
    for (size_t i = 0; i < 5; i++) {
        const json_t *row = json_array_get(json_object_get(root, "rows"), i);
        assert_string_equal(json_string_value(json_object_get(row, "protocol")), order[i]);
    }
    check_row(root, "rendering", 4 * TINY_VIEWS, mean_psnr_of_files("saved", "view", TINY_VIEWS, 0, 3));
    check_row(root, "given", 3 * TINY_VIEWS, mean_psnr_of_files("saved", "view", TINY_VIEWS, 0, 2));
    check_row(root, "unseen", TINY_VIEWS, mean_psnr_of_files("saved", "view", TINY_VIEWS, 3, 3));
    check_row(root, "novel_pattern", TINY_VIEWS, mean_psnr_of_files("saved", "view", TINY_VIEWS, 4, 4));
    check_row(root, "novel_pose", 2 * TINY_PATTERNS, mean_psnr_of_files("saved", "novel", 2, 0, 4));
    const double unseen =
        json_real_value(json_object_get(find_row(root, "rendering"), "psnr_unseen_lollipops"));
    assert_true(fabs(unseen - mean_psnr_of_files("saved", "view", TINY_VIEWS, 3, 3)) <= 0.02);
    assert_true(unseen > 20); // a ball is easy
    assert_true(json_is_null(json_object_get(find_row(root, "novel_pose"), "psnr_unseen_lollipops")));
    json_decref(root);
    assert_non_null(strstr(run.out, "novel_pose"));
    assert_true(is_there("%s/report.html", scratch));
}

static void test_gaussians_from_a_file_score_as_those_just_made(void **state) {
    (void)state;
    assert_int_equal(
        run_format(&run, "evaluate %s/tiny --model none --polish 8 --json %s/made.json", scratch, scratch),
        0);
    assert_int_equal(run_format(&run, "evaluate %s/tiny --gaussians %s/tiny.ply --json %s/read.json", scratch,
                                scratch, scratch),
                     0);
    json_t *made = load_json("made.json"), *read = load_json("read.json");
    const double a = json_real_value(json_object_get(find_row(made, "rendering"), "psnr"));
    const double b = json_real_value(json_object_get(find_row(read, "rendering"), "psnr"));
    assert_true(fabs(a - b) < 0.02);
    assert_true(json_is_null(json_object_get(find_row(read, "rendering"), "reconstruct_s")));
    json_decref(made);
    json_decref(read);
}

static double figure(const char *name, const char *protocol, const char *key) {
    json_t *root = load_json(name);
    const double value = json_real_value(json_object_get(find_row(root, protocol), key));
    json_decref(root);
    return value;
}

static void test_polish_is_worth_its_steps(void **state) {
    (void)state;
    assert_int_equal(run_format(&run,
                                "evaluate %s/tiny --model none --targets targets.json --polish 0 --json "
                                "%s/alone.json",
                                scratch, scratch),
                     0);
    assert_int_equal(run_format(&run,
                                "evaluate %s/tiny %s/tiny --model none --targets targets.json --json "
                                "%s/polished.json",
                                scratch, scratch, scratch),
                     0);
    assert_non_null(strstr(run.out, "\nmean  ")); // of two captures, which are the same
    static const char *const protocols[] = {"novel_pose", "rendering", "novel_pattern"};
    for (int i = 0; i < 3; i++)
        assert_true(figure("polished.json", protocols[i], "psnr") >
                    figure("alone.json", protocols[i], "psnr") + (i > 0 ? 3 : 0));
    json_t *root = load_json("polished.json"), *mean = json_array_get(json_object_get(root, "means"), 0);
    assert_true(json_real_value(json_object_get(mean, "psnr")) ==
                figure("polished.json", "novel_pattern", "psnr"));
    assert_true(json_is_null(json_object_get(mean, "depth_lit_median"))); // no truth in these files
    json_decref(root);
}

static void test_the_matching_predictor_leaves_new_poses_out(void **state) {
    (void)state;
    assert_int_equal(
        run_format(&run, "evaluate %s/tiny --predictor match --targets targets.json --json %s/match.json",
                   scratch, scratch),
        0);
    json_t *root = load_json("match.json");
    assert_int_equal(json_array_size(json_object_get(root, "rows")), 4);
    assert_true(json_real_value(json_object_get(find_row(root, "rendering"), "psnr_unseen_lollipops")) > 20);
    json_decref(root);
}

// Rows of different predictors are kept apart by its name, which the library gives.
static void test_rows_say_what_predicted(void **state) {
    (void)state;
    static const struct {
        const char *options, *name;
    } table[] = {
        {"--model none", "the classical initialisation, without weights"},
        {"--gaussians %s/tiny.ply", "%s/tiny.ply"},
        {"--predictor match", "pattern lookup at the matched depth"},
        {"", "the shipped weights"},
    };
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        char options[256], name[256], line[1024];
        snprintf(options, sizeof options, table[i].options, scratch);
        snprintf(name, sizeof name, table[i].name, scratch);
        snprintf(line, sizeof line, "evaluate %s/tiny %s --polish 0 --json %s/named.json", scratch, options,
                 scratch);
        assert_int_equal(run_format(&run, "%s", line), 0);
        json_t *root = load_json("named.json");
        assert_string_equal(json_string_value(json_object_get(root, "predictor")), name);
        json_decref(root);
    }
}

// A scene made, weights trained on others for three steps with a stop in between, the scene reconstructed
// with them.
static void test_generate_train_evaluate(void **state) {
    (void)state;
    static const char config[] =
        "{\"model\": \"tiny\", \"steps\": 3, \"resolution\": 16, "
        "\"views\": 2, \"targets\": 1, \"supervised_inputs\": 1, \"supervised_targets\": 1, "
        "\"lollipops\": 1, \"pool\": 1, \"pattern_side\": 64, \"samples\": 1, "
        "\"ambient_rays\": 1, \"validate_every\": 0, \"validation_scenes\": 1}";
    char path[256];
    snprintf(path, sizeof path, "%s/config.json", scratch);
    assert_true(ffp_write_file(path, config, strlen(config), NULL));
    assert_int_equal(run_format(&run, "train --out %s/run --config %s --steps 2", scratch, path), 0);
    assert_int_equal(run_format(&run, "train --out %s/run --resume --steps 3", scratch), 0);
    assert_int_equal(run_format(&run, "info %s/run/weights.safetensors", scratch), 0);
    assert_non_null(strstr(run.out, "model        tiny"));
    assert_int_equal(
        run_format(&run, "generate %s/scenes --split test --preset smoke --resolution 32 --count 1 --seed 5",
                   scratch),
        0);
    assert_int_equal(
        run_format(&run,
                   "evaluate %s/scenes/test_00000 --model %s/run/weights.safetensors --polish 8 --targets "
                   "targets/scene.json "
                   "--json "
                   "%s/trained.json",
                   scratch, scratch, scratch),
        0);
    assert_int_equal(run_format(&run,
                                "evaluate %s/scenes/test_00000 --model none --polish 8 --json %s/start.json",
                                scratch, scratch),
                     0);
    json_t *trained = load_json("trained.json"), *start = load_json("start.json");
    assert_non_null(find_row(trained, "novel_pose"));
    const double a = json_real_value(json_object_get(find_row(trained, "rendering"), "psnr"));
    const double b = json_real_value(json_object_get(find_row(start, "rendering"), "psnr"));
    assert_true(fabs(a - b) < 1); // three steps from the classical initialisation are not far from it
    const double depth = figure("trained.json", "rendering", "depth_lit_median"),
                 albedo = figure("trained.json", "rendering", "albedo_mse");
    assert_true(depth > 0 && depth < 10 && albedo > 0 && albedo < 0.1);
    json_decref(trained);
    json_decref(start);
}

static double now(void) {
    struct timespec at;
    clock_gettime(CLOCK_MONOTONIC, &at);
    return (double)at.tv_sec + 1e-9 * (double)at.tv_nsec;
}

// Runs the program and kills it if it has not ended within the given seconds.
static void run_and_kill(const char *const arguments[], double seconds) {
    const pid_t child = fork();
    if (child == 0) {
        if (!freopen("/dev/null", "w", stdout) || !freopen("/dev/null", "w", stderr)) _exit(126);
        execv(FFP_PROGRAM, (char *const *)arguments);
        _exit(127);
    }
    nanosleep(&(struct timespec){(time_t)seconds, (long)(1e9 * (seconds - (double)(time_t)seconds))}, NULL);
    kill(child, SIGKILL);
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_false(WIFEXITED(status) && WEXITSTATUS(status) != 0);
}

// Killed at any moment of a run's length: the file that was there before, or a whole new one.
static void test_a_killed_run_leaves_a_whole_file(void **state) {
    (void)state;
    char capture[128], output[128];
    snprintf(capture, sizeof capture, "%s/tiny", scratch);
    snprintf(output, sizeof output, "%s/killed.ply", scratch);
    // Without a polish, so that more of the moments lie about the writing.
    const char *const arguments[] = {FFP_PROGRAM, "reconstruct", capture,    "-o", output,
                                     "--model",   "none",        "--polish", "0",  NULL};
    const double begin = now();
    assert_int_equal(run_format(&run, "reconstruct %s -o %s --model none --polish 0", capture, output), 0);
    const double length = now() - begin;
    for (int i = 0; i < KILLS; i++) {
        assert_true(ffp_write_file(output, "old", 3, NULL));
        run_and_kill(arguments, length * 1.2 * i / KILLS);
        char *data;
        size_t size;
        assert_true(ffp_read_file(output, 1 << 26, &data, &size, NULL));
        if (size != 3 || memcmp(data, "old", 3) != 0) {
            FfpGaussians gaussians;
            FfpError err = {0};
            assert_true(ffp_gaussians_read(&gaussians, output, &err));
            ffp_gaussians_free(&gaussians);
        }
        ffp_free(data);
    }
}

// A training run ends by writing its checkpoint. Killed around that moment, the last checkpoint is whole, and
// the next run goes on from it.
static void test_a_killed_training_run_leaves_a_whole_checkpoint(void **state) {
    (void)state;
    char folder[128], path[256], last[32];
    snprintf(folder, sizeof folder, "%s/run", scratch); // test_generate_train_evaluate left it, at step 3
    snprintf(path, sizeof path, "%s/checkpoint.safetensors", folder);
    double begin = now();
    assert_int_equal(run_format(&run, "train --out %s --resume --steps 4", folder), 0);
    const double length = now() - begin;
    for (int i = 0, step = 4; i < KILLS / 2; i++) {
        snprintf(last, sizeof last, "%d", step + 1);
        const char *const arguments[] = {FFP_PROGRAM, "train",   "--out", folder,
                                         "--resume",  "--steps", last,    NULL};
        run_and_kill(arguments, length * (0.4 + 0.8 * i / (KILLS / 2)));
        FfpAdam adam;
        FfpTrainConfig config;
        FfpError err = {0};
        char origin[FFP_ORIGIN_MAX];
        FfpModel *model = ffp_checkpoint_read(path, &adam, &config, origin, &err);
        if (!model) fail_msg("%s", err.text);
        assert_true(adam.step == step || adam.step == step + 1);
        step = (int)adam.step;
        ffp_adam_free(&adam);
        ffp_model_free(model);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_info_tells_what_files_hold),
        cmocka_unit_test(test_render_writes_the_pictures_and_maps_it_is_asked_for),
        cmocka_unit_test(test_render_looks_from_where_it_is_told),
        cmocka_unit_test(test_told_psnr_is_that_of_the_saved_pictures),
        cmocka_unit_test(test_gaussians_from_a_file_score_as_those_just_made),
        cmocka_unit_test(test_polish_is_worth_its_steps),
        cmocka_unit_test(test_the_matching_predictor_leaves_new_poses_out),
        cmocka_unit_test(test_rows_say_what_predicted),
        cmocka_unit_test(test_generate_train_evaluate),
        cmocka_unit_test(test_a_killed_run_leaves_a_whole_file),
        cmocka_unit_test(test_a_killed_training_run_leaves_a_whole_checkpoint),
    };
    return cmocka_run_group_tests(tests, group_setup, scratch_teardown);
}
