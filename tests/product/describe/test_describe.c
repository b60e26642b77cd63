// `info` of photographs too large to be read at once says the same of them, from reduced ones.
#include "core/base/alloc.h"
#include "core/base/text.h"
#include "product/describe/print.h"
#include "scratch.h"

static char *said_of(const char *path, double values, bool *reduced, int *width) {
    FfpLooked looked;
    FfpError err = {0};
    FfpText *text = ffp_text_new();
    if (!ffp_looked_open(&looked, path, values, &err)) fail_msg("%s", err.text);
    *reduced = looked.reduced;
    *width = looked.seen.views[0].camera.width;
    FfpFindings found = {0};
    ffp_print_capture(ffp_text_stream(text), &looked, &found);
    ffp_findings_free(&found);
    ffp_looked_free(&looked);
    return ffp_text_end(text);
}

static void must_say(const char *text, const char *what) {
    if (!strstr(text, what)) fail_msg("not said: %s\n%s", what, text);
}

// The sample with a file that says its sphere, which data/sample's does not.
static const char *written_sample(void) {
    FfpCapture capture;
    FfpError err = {0};
    const char *folder = in_scratch("sample");
    if (!ffp_capture_read(&capture, FFP_SOURCE_DIR "/data/sample", &err) ||
        !ffp_capture_write_whole(&capture, folder, NULL, NULL, &err))
        fail_msg("%s", err.text);
    ffp_capture_free(&capture);
    return folder;
}

static void large_photographs_are_reduced(void **state) {
    (void)state;
    const char *folder = written_sample();
    bool reduced;
    int width;
    char *whole = said_of(folder, 512e6, &reduced, &width);
    assert_false(reduced);
    assert_int_equal(width, 128);
    char *small = said_of(folder, 2e6, &reduced, &width);
    assert_true(reduced);
    assert_true(width > 32 && width < 96);
    const char *const lines[] = {"views        8\n",       "truth        depth",
                                 "camera 128 x 128, f ",   "; 8 pictures\n",
                                 "reconstructs from ",     "ok   frusta ",
                                 "ok   silhouettes  0.",   "ok   size         128 x 128 pixels",
                                 "ok   pattern      'loll"};
    for (size_t i = 0; i < sizeof lines / sizeof *lines; i++) {
        must_say(whole, lines[i]);
        must_say(small, lines[i]);
    }
    must_say(small, "looked at    photographs reduced to ");
    assert_null(strstr(whole, "reduced to"));
    ffp_free(whole);
    ffp_free(small);
}

// Whatever is left in its files is checked as it is read.
static void broken_photographs_are_found(void **state) {
    (void)state;
    FfpLooked looked;
    FfpError err = {0};
    const char *folder = in_scratch("sample");
    char file[FFP_PATH_MAX];
    assert_true(ffp_join_path(file, folder, "path_0_theta135_lollipop_3.png"));
    assert_int_equal(truncate(file, 2000), 0);
    assert_false(ffp_looked_open(&looked, folder, 2e6, &err));
    must_say(err.text, "path_0_theta135_lollipop_3.png");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(large_photographs_are_reduced),
        cmocka_unit_test(broken_photographs_are_found),
    };
    return cmocka_run_group_tests(tests, scratch_setup, scratch_teardown);
}
