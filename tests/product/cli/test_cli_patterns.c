// The folder of what is to be shown: whole, numbered, and refused where it could not be right.
#include "core/image/image.h"
#include "product/cli/program.h"

static ProgramRun run;

static void a_folder_to_show(void **state) {
    (void)state;
    char *text;
    size_t size;
    FfpImage image = {0};
    FfpError err = {0};
    assert_int_equal(run_format(&run, "patterns -o %s/p --projector 160x90", scratch), 0);
    assert_non_null(strstr(run.out, "34 patterns of 160 x 90"));
    if (!ffp_image_read(&image, in_scratch("p/003_lollipop_0.png"), FFP_COLOUR_ENCODED, &err))
        fail_msg("%s", err.text);
    assert_true(image.width == 160 && image.height == 90);
    ffp_image_free(&image);
    assert_true(ffp_is_file(in_scratch("p/000_focus.png")));
    assert_true(ffp_is_file(in_scratch("p/033_gray_y_06_inverse.png")));
    assert_true(ffp_read_text(in_scratch("p/README.txt"), 1 << 20, &text, &size, &err));
    assert_non_null(strstr(text, "003_lollipop_0.png"));
    assert_non_null(strstr(text, "--graycode 'codes/{view}/*.JPG'"));
    assert_non_null(strstr(text, "-m 'masks/{view}.png'"));
    // The photographs, the empty stage first.
    const char *empty = strstr(text, "empty/ "), *board = strstr(text, "attitude-00/ ");
    assert_true(empty && board && empty < board && strstr(board, "001 to 033"));
    assert_non_null(strstr(empty, "001 to 003"));
    assert_non_null(strstr(text, "--shown PATTERNS"));
    ffp_free(text);
    assert_true(ffp_read_text(in_scratch("p/show.html"), 1 << 24, &text, &size, &err));
    assert_non_null(strstr(text, "const first = 0, panel = [160, 90]"));
    assert_null(strstr(text, "http"));
    ffp_free(text);
}

static void a_part_of_them(void **state) {
    (void)state;
    assert_int_equal(run_format(&run, "patterns -o %s/q --only capture --lollipops 1 --only focus", scratch),
                     0);
    assert_non_null(strstr(run.out, "4 patterns of 1920 x 1080"));
}

static void what_is_refused(void **state) {
    (void)state;
    assert_int_equal(run_format(&run, "patterns -o %s/r --projector 1920", scratch), 2);
    assert_non_null(strstr(run.err, "width x height"));
    assert_int_equal(run_format(&run, "patterns -o %s/r --projector 20000x1080", scratch), 1);
    assert_non_null(strstr(run.err, "20000 x 1080"));
    assert_int_equal(run_format(&run, "patterns -o %s/r --only everything", scratch), 2);
    assert_int_equal(run_format(&run, "patterns -o %s/p", scratch), 1); // is full already
    assert_false(ffp_is_folder(in_scratch("r")));
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(a_folder_to_show), cmocka_unit_test(a_part_of_them),
                                       cmocka_unit_test(what_is_refused)};
    return cmocka_run_group_tests(tests, scratch_setup, scratch_teardown);
}
