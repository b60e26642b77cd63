// A folder of patterns as a list of photographs, and what is not one.
#include "core/image/image.h"
#include "core/patterns/patterns.h"
#include "core/patterns/shown.h"
#include "scratch.h"

static FfpError err;
static FfpShown shown;

static void draw(const char *name, int lollipops, bool codes) {
    const FfpShow show = {.width = 80,
                          .height = 70,
                          .lollipops = lollipops,
                          .focus = true,
                          .capture = true,
                          .gray_codes = codes};
    if (!ffp_show_write_folder(&show, in_scratch(name), &err)) fail_msg("%s", err.text);
}

static void what_patterns_wrote(void **state) {
    (void)state;
    draw("all", 2, true);
    if (!ffp_shown_read(&shown, in_scratch("all"), &err)) fail_msg("%s", err.text);
    assert_true(shown.width == 80 && shown.height == 70 && shown.n == 4 + 28 && shown.n_codes == 28);
    static const char *const names[] = {"black", "white", "lollipop_0", "lollipop_1", "gray_x_00"};
    for (int i = 0; i < 5; i++) assert_string_equal(shown.patterns[i].name, names[i]);
    assert_string_equal(shown.patterns[31].name, "gray_y_06_inverse");
    assert_non_null(strstr(shown.patterns[2].file, "/003_lollipop_0.png"));
    ffp_shown_free(&shown);
    draw("few", 1, false);
    assert_true(ffp_shown_read(&shown, in_scratch("few"), &err));
    assert_true(shown.n == 3 && shown.n_codes == 0);
    ffp_shown_free(&shown);
}

static void what_is_refused(void **state) {
    (void)state;
    static const char *const table[][2] = {
        {"rm -r ../fault", "cannot read the patterns' folder"},
        {"rm *.png", "no picture is called <number>_<name>.png"},
        {"rm 003_*", "number 003 is missing"},
        {"cp 003_lollipop_0.png 003_other.png", "has the same number as"},
        {"mv 003_lollipop_0.png 000_lollipop_0.png", "their numbers are 1 to 999"},
        {"mv 001_black.png x && mv 002_white.png 001_white.png && mv x 002_black.png",
         "number 001 is not black"},
        {"mv 004_gray_x_00.png x && mv 006_gray_x_01.png 004_gray_x_01.png && mv x 006_gray_x_00.png",
         "number 004 is not gray_x_00: a panel of 80 x 70 pixels has 28 Gray codes"},
        {"rm 031_*", "number 031 is not gray_y_06_inverse"},
        {"cp 001_black.png 032_more.png", "number 032 is not there"},
        {"cp ../wide.png 003_lollipop_0.png", "90 x 70 pixels, but the first pattern has 80 x 70"},
        {": > 004_gray_x_00.png", "004_gray_x_00.png"}};
    FfpImage wide = ffp_pattern_plain(90, 70, 9);
    assert_true(ffp_image_write_png(&wide, in_scratch("wide.png"), &err));
    ffp_image_free(&wide);
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        char command[1024];
        draw("fault", 1, true);
        snprintf(command, sizeof command, "cd %s && %s", in_scratch("fault"), table[i][0]);
        assert_int_equal(system(command), 0);
        assert_false(ffp_shown_read(&shown, in_scratch("fault"), &err));
        if (!strstr(err.text, table[i][1]) || !strstr(err.text, "fault"))
            fail_msg("%s: '%s' is not in '%s'", table[i][0], table[i][1], err.text);
        ffp_shown_free(&shown);
        snprintf(command, sizeof command, "rm -rf %s", in_scratch("fault"));
        assert_int_equal(system(command), 0);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(what_patterns_wrote),
                                       cmocka_unit_test(what_is_refused)};
    return cmocka_run_group_tests(tests, scratch_setup, scratch_teardown);
}
