// Work that several runs share: a folder of scenes says what it lacks, and scores of parts become one table.
#include <jansson.h>
#include <math.h>
#include "program.h"

#define SCENES "--preset smoke --split train --resolution 16"

static ProgramRun run;

static void must(const char *arguments) {
    run_program(&run, arguments);
    if (run.status != 0) fail_msg("%s\n%s", arguments, run.err);
}

static void must_say(int status, const char *arguments, const char *words) {
    run_program(&run, arguments);
    if (run.status != status || !strstr(run.err, words))
        fail_msg("%s: exit %d\n%s", arguments, run.status, run.err);
}

static char *line(const char *form) {
    static char lines[4][1024];
    static int turn;
    turn = (turn + 1) % 4;
    snprintf(lines[turn], sizeof lines[turn], form, scratch, scratch, scratch, scratch, scratch);
    return lines[turn];
}

static void a_folder_says_what_it_lacks(void **state) {
    (void)state;
    must_say(1, line("generate %s/scenes " SCENES " --count 3 --check"), "3 of 3 scenes are missing");
    assert_false(ffp_is_file(in_scratch("scenes/train_00000/scene.json")));
    must(line("generate %s/scenes " SCENES " --count 1"));
    must(line("generate %s/scenes " SCENES " --first 2 --count 1"));
    must_say(1, line("generate %s/scenes " SCENES " --count 3 --check"),
             "1 of 3 scenes are missing: train_00001 ");
    must(line("generate %s/scenes " SCENES " --first 1 --count 1"));
    must_say(0, line("generate %s/scenes " SCENES " --count 3 --check"), "all 3 scenes exist");
    must_say(1, line("generate %s/scenes " SCENES " --count 9 --check"),
             "6 of 9 scenes are missing: train_00003, ");
}

static json_t *load(const char *name) {
    json_t *root = json_load_file(in_scratch(name), 0, NULL);
    assert_non_null(root);
    return root;
}

static double mean_psnr(const json_t *root) {
    return json_number_value(json_object_get(json_array_get(json_object_get(root, "means"), 0), "psnr"));
}

#define EVALUATE "evaluate --model none --polish 0 %s/scenes/train_00000 "

// Rows of parts are those of the whole, but for the seconds.
static void scores_of_parts_make_the_whole(void **state) {
    (void)state;
    must(line(EVALUATE "%s/scenes/train_00001 --json %s/whole.json"));
    must(line(EVALUATE "--json %s/first.json"));
    must(line("evaluate --model none --polish 0 %s/scenes/train_00001 --json %s/second.json"));
    must(line("evaluate --merge %s/first.json --merge %s/second.json --json %s/merged.json"));
    assert_non_null(strstr(run.out, "\nmean "));
    json_t *whole = load("whole.json"), *merged = load("merged.json");
    json_t *a = json_object_get(whole, "rows"), *b = json_object_get(merged, "rows");
    assert_int_equal(json_array_size(a), 2 * 3); // unseen, rendering and given of each scene
    assert_int_equal(json_array_size(b), json_array_size(a));
    for (size_t i = 0; i < json_array_size(a); i++) {
        json_t *x = json_array_get(a, i), *y = json_array_get(b, i);
        json_object_del(x, "reconstruct_s"), json_object_del(x, "render_s");
        json_object_del(y, "reconstruct_s"), json_object_del(y, "render_s");
        assert_true(json_equal(x, y));
    }
    assert_true(json_equal(json_object_get(whole, "predictor"), json_object_get(merged, "predictor")));
    assert_true(fabs(mean_psnr(whole) - mean_psnr(merged)) < 1e-5);
    json_decref(whole), json_decref(merged);
}

static void merging_refuses(void **state) {
    (void)state;
    must_say(1, line("evaluate --merge %s/first.json --merge %s/first.json"), "duplicate row");
    must_say(1, line("evaluate --merge %s/scenes/train_00000/scene.json"), "predictor");
    must_say(1, line("evaluate --merge %s/none.json"), "none.json");
    must_say(2, line("evaluate %s/scenes/train_00000 --merge %s/first.json"), "no CAPTURE");
    static const char odd[] = "{\"predictor\": \"x\", \"rows\": [{\"capture\": \"a\", \"protocol\": \"b\"}]}";
    assert_true(ffp_write_file(in_scratch("odd.json"), odd, strlen(odd), NULL));
    must_say(1, line("evaluate --merge %s/odd.json"), "rows[0].protocol");
    must(line("evaluate --predictor depth %s/scenes/train_00000 --json %s/depth.json"));
    must_say(1, line("evaluate --merge %s/second.json --merge %s/depth.json --json %s/never.json"),
             "depth.json: predictor");
    assert_false(ffp_is_file(in_scratch("never.json")));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_folder_says_what_it_lacks),
        cmocka_unit_test(scores_of_parts_make_the_whole),
        cmocka_unit_test(merging_refuses),
    };
    return cmocka_run_group_tests(tests, scratch_setup, scratch_teardown);
}
