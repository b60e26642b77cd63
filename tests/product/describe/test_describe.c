// `info` of photographs too large to be read at once says the same of them, from reduced ones.
#include <math.h>
#include "core/base/alloc.h"
#include "core/base/file.h"
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

// --- What no pattern tells. ---

// Of the object's pixels of view 2 the first two fifths are unlit, and of view 5's a quarter has no code; all
// others are lit, or have one. There are no other photographs, whose checks take long. `of` [3]: such pixels
// of both views, and all of the object.
static void write_told(const char *folder, double of[3], double in[2]) {
    FfpCapture capture;
    FfpError err = {0};
    of[0] = of[1] = of[2] = 0;
    if (!ffp_capture_read(&capture, FFP_SOURCE_DIR "/data/sample", &err)) fail_msg("%s", err.text);
    capture.views[5].correspondence = ffp_image_new(128, 128, 3);
    for (int v = 0; v < capture.n_views; v++) {
        const FfpView *view = &capture.views[v];
        for (int p = 0; p < capture.n_patterns; p++)
            if (p != capture.black && p != capture.white) ffp_image_free(&view->images[p]);
        double object = 0, before = 0;
        for (int i = 0; i < 128 * 128; i++) object += view->coverage.data[i] >= 0.5F;
        of[2] += object;
        for (int i = 0; i < 128 * 128; i++) {
            if (view->coverage.data[i] < 0.5F) continue;
            const bool unlit = v == 2 && before < 0.4 * object, coded = v == 5 && before >= 0.25 * object;
            before++;
            of[0] += unlit, of[1] += v == 5 && !coded;
            for (int c = 0; c < 3; c++) {
                view->images[capture.black].data[3 * i + c] = 0.1F;
                view->images[capture.white].data[3 * i + c] = unlit ? 0.1F : 0.6F;
            }
            if (coded)
                for (int c = 0; c < 3; c++) view->correspondence.data[3 * i + c] = c < 2 ? 400 : 1;
        }
        if (v == 2) in[0] = of[0] / object;
        if (v == 5) in[1] = of[1] / object;
    }
    if (!ffp_capture_write_whole(&capture, folder, NULL, NULL, &err)) fail_msg("%s", err.text);
    ffp_capture_free(&capture);
}

// The number after `before`.
static double said_share(const char *text, const char *before) {
    const char *at = strstr(text, before);
    if (!at) fail_msg("not said: %s\n%s", before, text);
    return strtod(at + strlen(before), NULL);
}

static void guesses_are_said_and_shown(void **state) {
    (void)state;
    const char *folder = in_scratch("told");
    double of[3], in[2] = {0};
    size_t size;
    char *said = NULL;
    FfpError err = {0};
    char html[FFP_PATH_MAX];
    snprintf(html, sizeof html, "%s", in_scratch("told.html"));
    write_told(folder, of, in);
    if (!ffp_describe_report(folder, html, &err) || !ffp_read_file(html, 1 << 24, &said, &size, &err))
        fail_msg("%s", err.text);
    must_say(said, "told by no pattern of their view, most in view path_0_theta090 (40 %)");
    assert_true(fabs(said_share(said, "note guesses      ") - 100 * (of[0] + of[1]) / of[2]) <= 0.5);
    const char *pictures = strstr(said, "How depth is known");
    assert_non_null(pictures);
    assert_true(fabs(said_share(pictures, "<figcaption>path_0_theta090: ") - 100 * in[0]) <= 0.051);
    assert_true(fabs(said_share(pictures, "<figcaption>path_0_theta225: ") - 100 * in[1]) <= 0.051);
    assert_true(said_share(pictures, "<figcaption>path_0_theta000: ") <= 0);
    ffp_free(said);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(large_photographs_are_reduced),
        cmocka_unit_test(broken_photographs_are_found),
        cmocka_unit_test(guesses_are_said_and_shown),
    };
    return cmocka_run_group_tests(tests, scratch_setup, scratch_teardown);
}
