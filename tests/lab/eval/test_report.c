// The report is one page that needs nothing else, whatever the names in it; the JSON rows say null where
// there is no figure.
#include <jansson.h>
#include <math.h>
#include "core/base/alloc.h"
#include "core/base/call.h"
#include "core/base/file.h"
#include "core/capture/node.h"
#include "lab/eval/evaluate.h"
#include "lab/eval/report.h"
#include "lab/eval/scores.h"
#include "support.h"

typedef struct Evaluation {
    const FfpEvaluation *options;
    int *count;
    FfpScore *rows;
} Evaluation;

static bool run(void *argument, FfpError *err) {
    Evaluation *evaluation = argument;
    evaluation->rows = ffp_evaluation_run(evaluation->options, evaluation->count, err);
    return evaluation->rows != NULL;
}

// In a call of its own, which gives back what a failed evaluation has taken.
static FfpScore *evaluate(const FfpEvaluation *options, int *count, FfpError *err) {
    Evaluation evaluation = {options, count, NULL};
    return ffp_call_run(NULL, run, &evaluation, err) ? evaluation.rows : NULL;
}

static const FfpScore scores[] = {
    {.capture = "one",
     .protocol = "rendering",
     .psnr = 30,
     .psnr_foreground = 25,
     .psnr_gloss = NAN,
     .ssim = 0.9,
     .lpips = NAN,
     .psnr_unseen_lollipops = 28,
     .images = 10,
     .images_unseen = 4,
     .reconstruct_s = 1.5,
     .render_s = 2,
     .depth_lit_median = 1,
     .depth_lit_p90 = NAN,
     .albedo_mse = 0.5},
    {.capture = "two",
     .protocol = "rendering",
     .psnr = 20,
     .psnr_foreground = 15,
     .psnr_gloss = 12,
     .ssim = 0.7,
     .lpips = NAN,
     .psnr_unseen_lollipops = 18,
     .images = 10,
     .images_unseen = 4,
     .reconstruct_s = 0.5,
     .render_s = 1,
     .depth_lit_median = 3,
     .depth_lit_p90 = 2,
     .albedo_mse = 0.25},
    {.capture = "two",
     .protocol = "novel_pose",
     .psnr = 10,
     .psnr_foreground = NAN,
     .psnr_gloss = NAN,
     .ssim = 0.5,
     .lpips = NAN,
     .psnr_unseen_lollipops = NAN,
     .images = 6,
     .reconstruct_s = 0.5,
     .render_s = 1},
};

static char text[1 << 16];

static void read_all(const char *path) {
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    text[fread(text, 1, sizeof text - 1, file)] = 0;
    fclose(file);
    assert_int_equal(remove(path), 0);
}

static unsigned base64_value(char c) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const char *at = strchr(digits, c);
    assert_non_null(at);
    return (unsigned)(at - digits);
}

static size_t decode_base64(const char *code, unsigned char *out) {
    size_t size = 0;
    for (; *code != '"'; code += 4) {
        const unsigned pad = (code[2] == '=') + (code[3] == '=');
        const unsigned bits = base64_value(code[0]) << 18 | base64_value(code[1]) << 12 |
                              (pad < 2 ? base64_value(code[2]) << 6 : 0) |
                              (pad < 1 ? base64_value(code[3]) : 0);
        out[size++] = (unsigned char)(bits >> 16);
        if (pad < 2) out[size++] = (unsigned char)(bits >> 8);
        if (pad < 1) out[size++] = (unsigned char)bits;
    }
    return size;
}

static void test_pictures_in_the_page_are_the_pictures_given(void **state) {
    (void)state;
    static const char mark[] = "data:image/png;base64,";
    for (int width = 1; width < 6; width++) { // all lengths modulo 3 occur
        FfpReport *report = ffp_report_new("nobody");
        FfpImage image = ffp_image_new(width, 3, 3);
        for (int i = 0; i < 9 * width; i++) image.data[i] = (real)(i * 37 % 256) / 255;
        ffp_report_picture(report, &image, "a picture");
        assert_true(ffp_report_write(report, scores, 1, NULL, "test_report.html", NULL));
        read_all("test_report.html");
        char *at = strstr(text, mark);
        assert_non_null(at);
        unsigned char *bytes = ffp_alloc(strlen(at), 1);
        assert_non_null(bytes);
        const size_t size = decode_base64(at + strlen(mark), bytes);
        assert_true(ffp_write_file("test_report.png", bytes, size, NULL));
        FfpImage back;
        assert_true(ffp_image_read(&back, "test_report.png", FFP_COLOUR_ENCODED, NULL));
        assert_int_equal(remove("test_report.png"), 0);
        assert_int_equal(back.width, width);
        for (int i = 0; i < 3 * width; i++)
            for (int c = 0; c < 3; c++) assert_float_equal(back.data[4 * i + c], image.data[3 * i + c], 1e-6);
        ffp_image_free(&back);
        ffp_image_free(&image);
        ffp_free(bytes);
        ffp_report_free(report);
    }
}

static void test_names_cannot_break_the_page(void **state) {
    (void)state;
    FfpReport *report = ffp_report_new("<script>alert(1)</script>");
    FfpImage image = ffp_image_new(2, 2, 3);
    ffp_report_picture(report, &image, "<img src=\"http://elsewhere\"> & more");
    FfpScore score = scores[0];
    strcpy(score.capture, "</table><script>");
    assert_true(ffp_report_write(report, &score, 1, "\"><script>", "test_report.html", NULL));
    read_all("test_report.html");
    assert_null(strstr(text, "<script"));
    assert_null(strstr(text, "src=\"http"));
    assert_non_null(strstr(text, "&lt;img src=&quot;http://elsewhere&quot;&gt; &amp; more"));
    assert_non_null(strstr(text, "</html>"));
    assert_non_null(strstr(text, "href=\"&quot;&gt;&lt;script&gt;\""));
    ffp_image_free(&image);
    ffp_report_free(report);
}

// Large pictures come first and tables last, and a page says that it fits a phone.
static void test_pictures_come_before_figures(void **state) {
    (void)state;
    FfpReport *report = ffp_report_new("nobody");
    FfpImage image = ffp_image_new(1100, 550, 3);
    ffp_report_large(report, &image, "a large picture");
    assert_true(ffp_report_write(report, scores, 1, NULL, "test_report.html", NULL));
    read_all("test_report.html");
    const char *picture = strstr(text, "<figure class=large>"), *table = strstr(text, "<table>");
    assert_true(picture && table && picture < table);
    assert_non_null(strstr(text, "name=viewport"));
    assert_null(strstr(text, "<a "));
    ffp_image_free(&image);
    ffp_report_free(report);
}

static void test_rows_and_means(void **state) {
    (void)state;
    const FfpEvaluation options = {.json = "test_scores.json", .model_name = "a \"name\""};
    assert_true(ffp_scores_write(scores, 3, &options, NULL));
    read_all("test_scores.json");
    json_t *root = json_loads(text, 0, NULL);
    assert_non_null(root);
    json_t *rows = json_object_get(root, "rows"), *means = json_object_get(root, "means");
    assert_int_equal(json_array_size(rows), 3);
    assert_int_equal(json_array_size(means), 2);
    json_t *last = json_array_get(rows, 2), *mean = json_array_get(means, 1);
    assert_true(json_is_null(json_object_get(last, "lpips")));
    assert_true(json_is_null(json_object_get(last, "psnr_foreground")));
    assert_string_equal(json_string_value(json_object_get(last, "protocol")), "novel_pose");
    assert_int_equal(json_integer_value(json_object_get(mean, "images")), 20);
    assert_float_equal(json_real_value(json_object_get(mean, "psnr")), 25, 1e-9);
    assert_float_equal(json_real_value(json_object_get(mean, "render_s")), 3, 1e-9); // of those 20 images
    assert_float_equal(json_real_value(json_object_get(mean, "reconstruct_s")), 1, 1e-9);
    assert_float_equal(json_real_value(json_object_get(mean, "psnr_unseen_lollipops")), 23, 1e-9);
    assert_true(json_is_null(json_object_get(mean, "lpips")));
    assert_float_equal(json_real_value(json_object_get(mean, "psnr_gloss")), 12,
                       1e-9); // of those that have it
    assert_true(json_is_null(json_object_get(json_array_get(means, 0), "psnr_gloss")));
    assert_float_equal(json_real_value(json_object_get(mean, "depth_lit_median")), 2, 1e-9);
    assert_float_equal(json_real_value(json_object_get(mean, "albedo_mse")), 0.375, 1e-9);
    assert_true(json_is_null(json_object_get(mean, "depth_lit_p90")));
    json_decref(root);
}

// Latin-1, say: JSON would lack them.
static void test_names_that_json_cannot_hold_are_refused(void **state) {
    (void)state;
    static const char odd[] = "f\xfcr";
    FfpError err = {0};
    assert_false(ffp_is_name(odd));
    assert_true(ffp_is_name("f\xc3\xbcr"));
    FfpScore score = scores[0];
    strcpy(score.capture, odd);
    FfpEvaluation options = {.json = "test_odd.json", .model_name = "plain"};
    assert_false(ffp_scores_write(&score, 1, &options, &err));
    if (!strstr(err.text, "not UTF-8 (test_odd.json: capture)")) fail_msg("%s", err.text);
    options.model_name = odd;
    assert_false(ffp_scores_write(scores, 1, &options, &err));
    if (!strstr(err.text, "not UTF-8 (test_odd.json: predictor)")) fail_msg("%s", err.text);
    // and before any work
    const char *const captures[] = {"nowhere"};
    int count;
    options.captures = captures, options.n_captures = 1;
    assert_null(evaluate(&options, &count, &err));
    if (!strstr(err.text, "(model_name)")) fail_msg("%s", err.text);
    assert_false(ffp_is_file("test_odd.json"));
}

// Rows 0 and 1 of one predictor, 2 of another, whose name differs at its end.
static void test_rows_of_different_predictors_are_not_merged(void **state) {
    (void)state;
    static const char *const files[] = {"test_one.json", "test_two.json", "test_other.json"};
    char name[160], other[160];
    FfpError err = {0};
    int count;
    snprintf(name, sizeof name, "%0140d", 1);
    snprintf(other, sizeof other, "%0140d", 2);
    for (int i = 0; i < 3; i++) {
        const FfpEvaluation one = {.json = files[i], .model_name = i < 2 ? name : other};
        assert_true(ffp_scores_write(&scores[i], 1, &one, &err));
    }
    FfpEvaluation merging = {.merged = files, .n_merged = 3, .json = "test_merged.json"};
    assert_null(evaluate(&merging, &count, &err));
    if (!strstr(err.text, "test_other.json: predictor")) fail_msg("%s", err.text);
    merging.n_merged = 2;
    FfpScore *merged = evaluate(&merging, &count, &err);
    if (!merged) fail_msg("%s", err.text);
    assert_int_equal(count, 3); // with their mean
    ffp_free(merged);
    read_all("test_merged.json");
    assert_non_null(strstr(text, name)); // all of it
    for (int i = 0; i < 3; i++) assert_int_equal(remove(files[i]), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_pictures_in_the_page_are_the_pictures_given),
        cmocka_unit_test(test_names_cannot_break_the_page),
        cmocka_unit_test(test_pictures_come_before_figures),
        cmocka_unit_test(test_rows_and_means),
        cmocka_unit_test(test_names_that_json_cannot_hold_are_refused),
        cmocka_unit_test(test_rows_of_different_predictors_are_not_merged),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
