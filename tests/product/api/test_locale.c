// A host may write its numbers with commas: files, pages and reports have points all the same, and
// calibrations are read.
#include <ctype.h>
#include "comma.h"
#include "ffprocams/lab.h"
#include "initialised.h"

static void write_page(const char *path, FfpError *err) {
    FfpPage how = ffp_page_defaults();
    how.file = path;
    assert_true(ffp_write_page(NULL, gaussians, capture, &how, NULL, err));
}

static void write_mesh(const char *path, FfpError *err) {
    FfpExport how = ffp_export_defaults();
    how.file = path, how.mesh = true, how.resolution = 16;
    assert_true(ffp_export(NULL, gaussians, capture, &how, NULL, err));
}

static void write_capture(const char *path, FfpError *err) {
    char folder[FFP_PATH_MAX];
    snprintf(folder, sizeof folder, "%.*s", (int)(strrchr(path, '/') - path), path);
    if (!ffp_capture_save(NULL, capture, folder, err)) fail_msg("%s", err->text);
}

static void write_scores(const char *path, FfpError *err) {
    char folder[FFP_PATH_MAX];
    snprintf(folder, sizeof folder, "%s/capture", scratch);
    const char *const captures[1] = {folder};
    FfpEvaluation how = ffp_evaluation_defaults();
    int n = 0;
    how.captures = captures, how.n_captures = 1, how.predictor = FFP_PREDICT_MATCH, how.report = path;
    FfpScore *scores = ffp_evaluate(NULL, &how, &n, err);
    if (!scores) fail_msg("%s", err->text);
    ffp_free(scores);
}

static void write_metrics(const char *path, FfpError *err) {
    const FfpRefinement how = {.size = sizeof how, .steps = 3, .metrics = path};
    FfpGaussians *fitted = ffp_fit_from_scratch(NULL, capture, NULL, &how, NULL, err);
    if (!fitted) fail_msg("%s", err->text);
    ffp_gaussians_close(fitted);
}

typedef struct Written {
    void (*write)(const char *path, FfpError *err);
    const char *names[2]; // under the C locale, and under one with commas
    const char *points;   // stands in front of a number with a point, in both
    bool timed;           // holds seconds too: the files are not the same
} Written;

// The number behind `before` has a point.
static bool has_point(const char *text, const char *before) {
    const char *at = strstr(text, before);
    if (!at) return false;
    at += strlen(before);
    return at[strspn(at, "-0123456789")] == '.';
}

// How many commas stand between digits.
static int commas_in(const char *text) {
    int count = 0;
    for (const char *at = strchr(text, ','); at; at = strchr(at + 1, ','))
        count += at > text && isdigit((unsigned char)at[-1]) && isdigit((unsigned char)at[1]);
    return count;
}

static void files_have_points(void **state) {
    (void)state;
    static const Written all[] = {
        {write_page, {"point.html", "comma.html"}, "\"radius\":", false},
        {write_mesh, {"point.obj", "comma.obj"}, "\nv ", false},
        {write_capture, {"point_capture/scene.json", "comma_capture/scene.json"}, "\"radius\": ", false},
        {write_scores, {"point_report.html", "comma_report.html"}, "", true},
        {write_metrics, {"point.jsonl", "comma.jsonl"}, "\"loss\": ", true},
    };
    enum { N = sizeof all / sizeof *all };
    FfpError err = {0};
    char path[FFP_PATH_MAX];
    for (int k = 0; k < 2; k++) {
        if (k == 1 && !comma_locale()) skip();
        for (int i = 0; i < N; i++) {
            assert_true(ffp_join_path(path, scratch, all[i].names[k]));
            all[i].write(path, &err);
        }
    }
    assert_true(with_comma()); // the host's own numbers are as they were
    setlocale(LC_NUMERIC, "C");
    for (int i = 0; i < N; i++) {
        char *text[2];
        size_t size[2];
        for (int k = 0; k < 2; k++)
            assert_true(ffp_read_file(in_scratch(all[i].names[k]), 1 << 28, &text[k], &size[k], &err));
        if (*all[i].points && !(has_point(text[0], all[i].points) && has_point(text[1], all[i].points)))
            fail_msg("%s: no point behind %s", all[i].names[1], all[i].points);
        if (!all[i].timed && (size[0] != size[1] || memcmp(text[0], text[1], size[0]) != 0))
            fail_msg("%s is not %s", all[i].names[1], all[i].names[0]);
        assert_int_equal(commas_in(text[1]), commas_in(text[0]));
        ffp_free(text[0]), ffp_free(text[1]);
    }
}

// The error of an import of these calibrations: the words are to be the same in every locale.
static void refuse_import(const char *const *files, int n, FfpError *err) {
    FfpImport how = ffp_import_defaults();
    how.calibrations = files, how.n_calibrations = n, how.folder = in_scratch("imported");
    assert_false(ffp_import_capture(NULL, &how, err));
}

static void calibrations_are_read(void **state) {
    (void)state;
    static const char yml[] = "%YAML:1.0\n---\n"
                              "camK: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n"
                              "   data: [ 1000.5, 0., 31.5, 0., 1000.5, 23.5, 0., 0., 1. ]\n"
                              "prjK: [ [ 90.5, 0, 15 ], [ 0, 90.5, 11 ], [ 0, 0, 1 ] ]\n"
                              "R: [ 1, 0, 0, 0, 1, 0, 0, 0, 1 ]\nT: [ 1.5, 0, 0 ]\n";
    static const char cameras[] = "1 PINHOLE 64 48 50.5 50.5 32.5 24.5\n";
    static const char images[] = "1 1 0 0 0 0.5 0 0.5 1 calib.png\n\n2 1 0 0 0 0.5 0 1.5 1 a.png\n\n";
    FfpError point[2], comma[2];
    assert_true(ffp_write_file(in_scratch("rig.yml"), yml, strlen(yml), NULL));
    assert_int_equal(mkdir(in_scratch("model"), 0777), 0);
    assert_true(ffp_write_file(in_scratch("model/cameras.txt"), cameras, strlen(cameras), NULL));
    assert_true(ffp_write_file(in_scratch("model/images.txt"), images, strlen(images), NULL));
    char paths[2][FFP_PATH_MAX];
    for (int i = 0; i < 2; i++)
        snprintf(paths[i], FFP_PATH_MAX, "%s/%s", scratch, i == 0 ? "rig.yml" : "model");
    const char *const files[2] = {paths[0], paths[1]};
    for (int i = 0; i < 2; i++) refuse_import(files + i, 1, &point[i]);
    if (!comma_locale()) skip();
    for (int i = 0; i < 2; i++) refuse_import(files + i, 1, &comma[i]);
    setlocale(LC_NUMERIC, "C");
    for (int i = 0; i < 2; i++) {
        assert_null(strstr(point[i].text, i == 0 ? "rig.yml" : "model/")); // what is amiss comes later
        assert_string_equal(comma[i].text, point[i].text);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(files_have_points),
        cmocka_unit_test(calibrations_are_read),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
