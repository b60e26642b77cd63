// The page of ffp_write_page: what it holds can be read back, names cannot break it, and it is whole or not
// there. Its look in a browser: tests/product/view.
#include <jansson.h>
#include <math.h>
#include "core/base/file.h"
#include "core/gaussians/gaussians.h"
#include "initialised.h"
#include "product/view/view.h"

static char *page;
static size_t page_size;

static FfpPageStats write_page(const FfpPage *how) {
    FfpError err = {0};
    FfpPageStats stats;
    if (!ffp_write_page(NULL, gaussians, capture, how, &stats, &err)) fail_msg("%s", err.text);
    ffp_free(page);
    assert_true(ffp_read_file(how->file, 1 << 28, &page, &page_size, &err));
    assert_int_equal(page_size, stats.bytes);
    return stats;
}

// The contents of the script element with that id, up to its end.
static char *element(const char *id) {
    char begin[64];
    snprintf(begin, sizeof begin, "id=\"%s\">", id);
    char *at = strstr(page, begin);
    assert_non_null(at);
    at += strlen(begin);
    *strstr(at, "</script>") = 0;
    return at;
}

static unsigned char *decode(const char *text, size_t *size) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    unsigned char *out = ffp_alloc(strlen(text) + 4, 1);
    unsigned bits = 0, held = 0;
    for (*size = 0; *text && *text != '='; text++) {
        const char *digit = strchr(digits, *text);
        assert_non_null(digit);
        bits = bits << 6 | (unsigned)(digit - digits), held += 6;
        if (held >= 8) held -= 8, out[(*size)++] = (unsigned char)(bits >> held & 255);
    }
    return out;
}

static double number(const json_t *array, size_t i) {
    return json_number_value(json_array_get(array, i));
}

// The centres to the bit; of the other numbers the opacity, which lies in the eighth column.
static void check_splats(const json_t *scene, const unsigned char *bytes, size_t size) {
    const size_t n = (size_t)json_integer_value(json_object_get(scene, "count"));
    const double low = number(json_object_get(scene, "low"), 7),
                 high = number(json_object_get(scene, "high"), 7);
    size_t at = 0;
    assert_true(n > 100 && size >= n * (12 + 2 * FFP_PAGE_COLUMNS));
    for (int64_t i = 0; i < gaussians->count; i++) {
        if (gaussians->opacity[i] < 1.0F / 255) continue;
        assert_memory_equal(bytes + 12 * at, gaussians->centre + 3 * i, 12); // little-endian machines alone
        const unsigned char *column = bytes + 12 * n + 2 * n * 7 + 2 * at;
        const double opacity = low + (high - low) * (column[0] | column[1] << 8) / 65535;
        assert_true(fabs(opacity - (double)gaussians->opacity[i]) < 1e-5);
        at++;
    }
    assert_int_equal(at, n);
}

static void test_what_it_holds_reads_back(void **state) {
    (void)state;
    const FfpPage how = {.size = sizeof how, .file = in_scratch("page.html"), .photographs = 8};
    const FfpPageStats stats = write_page(&how);
    size_t size;
    unsigned char *bytes = decode(element("data"), &size);
    json_t *scene = json_loads(element("scene"), 0, NULL);
    assert_non_null(scene);
    check_splats(scene, bytes, size);
    assert_int_equal(json_array_size(json_object_get(scene, "views")), SMALL_VIEWS);
    const json_t *patterns = json_object_get(scene, "patterns");
    assert_int_equal(json_array_size(patterns), stats.patterns);
    for (size_t i = 0; i < json_array_size(patterns); i++) {
        const json_t *pattern = json_array_get(patterns, i);
        const size_t from = (size_t)json_integer_value(json_object_get(pattern, "at")),
                     length = (size_t)json_integer_value(json_object_get(pattern, "size"));
        assert_true(length > 8 && from + length <= size);
        assert_memory_equal(bytes + from, "\x89PNG", 4);
    }
    assert_int_equal(stats.photographs, SMALL_VIEWS * capture->n_patterns);
    json_decref(scene);
    ffp_free(bytes);
}

static int count(const char *what) {
    int found = 0;
    for (const char *at = page; (at = strstr(at, what)); at++) found++;
    return found;
}

static void test_names_cannot_break_the_page(void **state) {
    (void)state;
    char before[FFP_NAME_MAX];
    const char *bad = "</script><script>alert(\"1\")\\\n@FFP_PAGE_DATA@";
    const FfpPage how = {.size = sizeof how, .file = in_scratch("page.html")};
    write_page(&how);
    const int scripts = count("</script>");
    memcpy(before, capture->name, sizeof before);
    snprintf(capture->name, sizeof capture->name, "%s", bad);
    write_page(&how);
    assert_int_equal(count("</script>"), scripts);
    json_t *scene = json_loads(element("scene"), 0, NULL);
    assert_string_equal(json_string_value(json_object_get(scene, "name")), bad);
    json_decref(scene);
    memcpy(capture->name, before, sizeof before);
}

static void test_the_real_projector_goes_along(void **state) {
    (void)state;
    const FfpPage how = {.size = sizeof how, .file = in_scratch("page.html")};
    write_page(&how);
    json_t *scene = json_loads(element("scene"), 0, NULL);
    assert_null(json_object_get(scene, "panel"));
    json_decref(scene);
    capture->panel =
        (FfpPanel){true, 1920, 1080, 2000, 1990, 960, 1080, {0.1F, 0, 0, 0, 0.25F}, true, {2, 2.5F, 3}, 0};
    write_page(&how);
    capture->panel = (FfpPanel){0};
    scene = json_loads(element("scene"), 0, NULL);
    const json_t *panel = json_object_get(scene, "panel");
    assert_int_equal(json_integer_value(json_object_get(panel, "width")), 1920);
    assert_true(json_number_value(json_object_get(panel, "fy")) == 1990);
    assert_true(number(json_object_get(panel, "lens"), 4) == 0.25);
    assert_true(number(json_object_get(panel, "gamma"), 1) == 2.5);
    json_decref(scene);
}

static void test_photographs_are_left_out_when_asked(void **state) {
    (void)state;
    const FfpPage how = {.size = sizeof how, .file = in_scratch("page.html")};
    assert_int_equal(write_page(&how).photographs, 0);
}

static void test_wrong_settings_are_refused(void **state) {
    (void)state;
    const size_t size = sizeof(FfpPage);
    const FfpPage wrong[] = {
        {.size = size, .file = NULL},
        {.size = size, .file = in_scratch("none.html"), .photographs = -1},
        {.size = size, .file = in_scratch("none.html"), .photographs = 5000},
        {.size = size, .file = in_scratch("none.html"), .drawing = {.form = FFP_FORM_GS_PROCAMS}},
        {.size = size, .file = in_scratch("none.html"), .poses = "/no/such/file.json"},
        {.size = size, .file = "/no/such/folder/page.html"}};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        FfpError err = {0};
        assert_false(ffp_write_page(NULL, gaussians, capture, &wrong[i], NULL, &err));
        assert_true(err.text[0]);
        assert_true((err.code == FFP_ERROR_UNSUPPORTED) == (wrong[i].drawing.form == FFP_FORM_GS_PROCAMS));
    }
    assert_false(ffp_is_file(in_scratch("none.html")));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_what_it_holds_reads_back),
        cmocka_unit_test(test_names_cannot_break_the_page),
        cmocka_unit_test(test_the_real_projector_goes_along),
        cmocka_unit_test(test_photographs_are_left_out_when_asked),
        cmocka_unit_test(test_wrong_settings_are_refused),
    };
    const int failed = cmocka_run_group_tests(tests, setup, teardown);
    ffp_free(page);
    return failed;
}
