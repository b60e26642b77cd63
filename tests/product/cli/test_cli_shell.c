// A real thing, from its photographs (data/shell): no change may make it worse.
// Labels: slow
#include <jansson.h>
#include "product/cli/program.h"

#define SHELL FFP_SOURCE_DIR "/data/shell"
#define LEAST 36.05 // dB of the object's pixels; 36.36 when this was written

static ProgramRun run;

// The codes that import holds out are predicted.
static void test_patterns_that_were_held_out(void **state) {
    (void)state;
    const char *capture = in_scratch("capture");
    assert_int_equal(
        run_format(&run,
                   "import -c '" SHELL "/calibration.yml' --camera-fit scaled -t '" SHELL
                   "/axis.json' -i 'black,white=" SHELL "/photographs/{index:3}/{pattern}.jpg' -g '" SHELL
                   "/photographs/{index:3}/gray/*.jpg' -m '" SHELL "/masks/{index:3}.png' -w 192 -o '%s'",
                   capture),
        0);
    assert_non_null(strstr(run.err, "pro_K the projector's"));
    assert_non_null(strstr(run.err, "of the projector's light (red, green, blue) spread"));
    assert_int_equal(run_format(&run, "evaluate '%s' --json '%s.json'", capture, capture), 0);
    char file[512];
    snprintf(file, sizeof file, "%s.json", capture);
    json_t *scores = json_load_file(file, 0, NULL), *row;
    size_t i;
    bool found = false;
    json_array_foreach(json_object_get(scores, "rows"), i, row) {
        if (strcmp(json_string_value(json_object_get(row, "protocol")), "novel_pattern") != 0) continue;
        const double psnr = json_real_value(json_object_get(row, "psnr_foreground"));
        print_message("%.2f dB\n", psnr);
        assert_true(psnr >= LEAST);
        found = true;
    }
    json_decref(scores);
    assert_true(found);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_patterns_that_were_held_out, scratch_setup, scratch_teardown)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
