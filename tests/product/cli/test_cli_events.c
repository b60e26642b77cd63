// --events: what a command does, as lines of JSON.
#include <jansson.h>
#include "product/cli/program.h"

static json_t *lines; // of the last run

// The command of the program with its events in a file; its exit status.
static int run_with_events(const char *command) {
    char text[2048], file[FFP_PATH_MAX], line[1 << 14];
    snprintf(file, sizeof file, "%s", in_scratch("events"));
    snprintf(text, sizeof text, "'%s' --events 7 %s 7>'%s' >/dev/null 2>&1", FFP_PROGRAM, command, file);
    const int status = system(text);
    json_decref(lines);
    lines = json_array();
    FILE *in = fopen(file, "r");
    assert_non_null(in);
    while (fgets(line, sizeof line, in)) {
        json_t *one = json_loads(line, 0, NULL);
        assert_non_null(one);
        json_array_append_new(lines, one);
    }
    fclose(in);
    return WEXITSTATUS(status);
}

static bool told(const char *event, const char *key, const char *value) {
    size_t i;
    json_t *line;
    json_array_foreach(lines, i, line) {
        const char *kind = json_string_value(json_object_get(line, "event"));
        const json_t *of = json_object_get(line, "finding") ? json_object_get(line, "finding") : line;
        const char *text = json_string_value(json_object_get(of, key));
        if (kind && text && strcmp(kind, event) == 0 && strcmp(text, value) == 0) return true;
    }
    return false;
}

static void stages_are_named(void **state) {
    char command[1024];
    (void)state;
    snprintf(command, sizeof command, "reconstruct '%s' --model none --polish 1 -o '%s'",
             FFP_SOURCE_DIR "/data/sample", in_scratch("x.ply"));
    assert_int_equal(run_with_events(command), 0);
    assert_true(told("progress", "stage", "noise") && told("progress", "stage", "matching"));
}

static void findings_and_errors(void **state) {
    (void)state;
    assert_int_equal(run_with_events("info " FFP_SOURCE_DIR "/data/sample"), 0);
    assert_true(told("finding", "code", "clipped") && told("finding", "severity", "ok"));
    assert_int_equal(run_with_events("calibrate --without-board " FFP_SOURCE_DIR "/data/sample -o x"), 1);
    assert_true(told("finding", "code", "place-left-out") && told("finding", "code", "too-few-usable"));
    assert_true(told("error", "code", "photographs-missing") && told("finding", "severity", "fault"));
    assert_int_equal(run_with_events("info /nowhere"), 1);
    assert_true(told("error", "where", "/nowhere"));
    assert_true(json_is_false(json_object_get(json_array_get(lines, json_array_size(lines) - 1), "fault")));
}

static void it_takes_an_open_descriptor_and_a_command(void **state) {
    (void)state;
    assert_int_equal(WEXITSTATUS(system("'" FFP_PROGRAM "' --events 7 info x 2>/dev/null")), 2);
    assert_int_equal(WEXITSTATUS(system("'" FFP_PROGRAM "' --events 2>/dev/null")), 2);
    assert_int_equal(WEXITSTATUS(system("'" FFP_PROGRAM "' --events x info y 2>/dev/null")), 2);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(stages_are_named),
        cmocka_unit_test(findings_and_errors),
        cmocka_unit_test(it_takes_an_open_descriptor_and_a_command),
    };
    return cmocka_run_group_tests(tests, scratch_setup, scratch_teardown);
}
