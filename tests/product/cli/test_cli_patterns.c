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

static void greys_lie_before_the_codes(void **state) {
    (void)state;
    FfpImage image = {0};
    FfpError err = {0};
    assert_int_equal(run_format(&run, "patterns -o %s/greys --projector 160x90 --greys 4", scratch), 0);
    assert_true(ffp_is_file(in_scratch("greys/003_lollipop_0.png")));
    assert_true(ffp_is_file(in_scratch("greys/004_grey_051.png")));
    assert_true(ffp_is_file(in_scratch("greys/008_gray_x_00.png")));
    if (!ffp_image_read(&image, in_scratch("greys/007_grey_204.png"), FFP_COLOUR_ENCODED, &err))
        fail_msg("%s", err.text);
    assert_float_equal(image.data[0], 0.8, 1e-6);
    ffp_image_free(&image);
    char *text;
    size_t size;
    assert_true(ffp_read_text(in_scratch("greys/README.txt"), 1 << 20, &text, &size, &err));
    assert_non_null(strstr(text, "makes of a value:\n\n    004_grey_051.png\n    005_grey_102.png"));
    const char *empty = strstr(text, "empty/ ");
    assert_true(empty && strstr(empty, "001 to 003")); // without greys
    ffp_free(text);
    assert_int_equal(run_format(&run, "patterns -o %s/many --projector 160x90 --greys 65", scratch), 2);
}

// At true size: the page's box in points, the first square in millimetres, objects where the table says.
static void the_chessboard_on_paper(void **state) {
    (void)state;
    char *text;
    size_t size;
    FfpError err = {0};
    assert_int_equal(
        run_format(&run, "patterns -o %s/board --projector 160x90 --board 7x5 --square 30", scratch), 0);
    assert_true(ffp_read_text(in_scratch("board/chessboard.svg"), 1 << 20, &text, &size, &err));
    assert_non_null(strstr(text, "width=\"297mm\" height=\"210mm\" viewBox=\"0 0 297 210\""));
    assert_non_null(strstr(text, "M28.5 9h30v30h-30zM88.5 9h30v30h-30z"));
    ffp_free(text);
    assert_true(ffp_read_file(in_scratch("board/chessboard.pdf"), 1 << 20, &text, &size, &err));
    assert_memory_equal(text, "%PDF-1.4", 8);
    assert_non_null(strstr(text, "/MediaBox [0 0 841.889764 595.275591]"));
    assert_non_null(strstr(text, "\n28.5 9 30 30 re\n"));
    assert_non_null(strstr(text, "7 x 5 inner corners, squares of 30 mm."));
    const char *table = text + strtol(strstr(text, "startxref\n") + 10, NULL, 10);
    assert_memory_equal(table, "xref\n0 7\n", 9);
    for (int i = 1; i < 7; i++) {
        char begin[16];
        snprintf(begin, sizeof begin, "%d 0 obj", i);
        assert_memory_equal(text + strtol(table + 9 + 20 * i, NULL, 10), begin, strlen(begin));
    }
    ffp_free(text);
    assert_true(ffp_read_text(in_scratch("board/README.txt"), 1 << 20, &text, &size, &err));
    assert_non_null(strstr(text, "--board 7x5"));
    assert_non_null(strstr(text, "--square 30"));
    ffp_free(text);
    assert_false(ffp_is_file(in_scratch("q/chessboard.pdf")));
    assert_int_equal(run_format(&run, "patterns -o %s/r --board 2x6", scratch), 1);
    assert_non_null(strstr(run.err, "2 x 6 corners"));
    assert_int_equal(run_format(&run, "patterns -o %s/r --square 501", scratch), 2);
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
                                       cmocka_unit_test(greys_lie_before_the_codes),
                                       cmocka_unit_test(the_chessboard_on_paper),
                                       cmocka_unit_test(what_is_refused)};
    return cmocka_run_group_tests(tests, scratch_setup, scratch_teardown);
}
