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
    const size_t columns = json_array_size(json_object_get(scene, "low"));
    assert_true(n > 100 && size >= n * (12 + 2 * columns));
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
    capture->panel = (FfpPanel){true, 1920,         1080, 2000,
                                1990, 960,          1080, {0.1F, 0, 0, 0, 0.25F},
                                true, {2, 2.5F, 3}, 0,    {0.01F, 0.02F, 0.03F},
                                18};
    write_page(&how);
    capture->panel = (FfpPanel){0};
    scene = json_loads(element("scene"), 0, NULL);
    const json_t *panel = json_object_get(scene, "panel");
    assert_int_equal(json_integer_value(json_object_get(panel, "width")), 1920);
    assert_true(json_number_value(json_object_get(panel, "fy")) == 1990);
    assert_true(number(json_object_get(panel, "lens"), 4) == 0.25);
    assert_true(number(json_object_get(panel, "gamma"), 1) == 2.5);
    const json_t *spread = json_object_get(panel, "spread");
    assert_true(fabs(number(json_object_get(spread, "share"), 2) - 0.03) < 1e-8);
    assert_true(json_number_value(json_object_get(spread, "deviation")) == 18);
    json_decref(scene);
}

// In three columns more, and only where there is any.
static void test_scattered_light_goes_along(void **state) {
    (void)state;
    const FfpPage how = {.size = sizeof how, .file = in_scratch("page.html")};
    const long long bytes = write_page(&how).bytes;
    json_t *scene = json_loads(element("scene"), 0, NULL);
    assert_int_equal(json_array_size(json_object_get(scene, "low")), FFP_PAGE_COLUMNS - 3);
    const size_t n = (size_t)json_integer_value(json_object_get(scene, "count"));
    json_decref(scene);
    for (int64_t i = 0; i < 3 * gaussians->count; i++)
        gaussians->scattered[i] = 0.01F * (real)(i % 3 + i % 2);
    gaussians->scatters = true;
    const long long more = write_page(&how).bytes - bytes;
    gaussians->scatters = false;
    size_t size;
    unsigned char *data = decode(element("data"), &size);
    scene = json_loads(element("scene"), 0, NULL);
    assert_int_equal(json_array_size(json_object_get(scene, "low")), FFP_PAGE_COLUMNS);
    assert_true(fabs(number(json_object_get(scene, "high"), 17) - 0.03) < 1e-7);
    check_splats(scene, data, size);
    assert_in_range(more, 8 * n, 8 * n + 200); // 6 bytes as base64
    ffp_free(data);
    json_decref(scene);
}

static void test_photographs_are_left_out_when_asked(void **state) {
    (void)state;
    const FfpPage how = {.size = sizeof how, .file = in_scratch("page.html")};
    assert_int_equal(write_page(&how).photographs, 0);
}

enum { MANY = 12, GRAINY = 300 }; // views; pixels a side of photographs that no PNG makes small

static void make_grainy(FfpCapture *many) {
    FfpError err = {0};
    FfpSceneSpec spec = ffp_scene_defaults();
    spec.mesh = 3, spec.material = 2, spec.resolution = SMALL_SIDE, spec.pattern_side = SMALL_PATTERN;
    spec.views = MANY, spec.targets = 0, spec.lollipops = 1, spec.samples = 1, spec.ambient_rays = 1;
    if (!ffp_scene_make(many, &spec, &err)) fail_msg("%s", err.text);
    unsigned seed = 1;
    for (int v = 0; v < MANY; v++) {
        FfpView *view = &many->views[v];
        view->camera.width = view->camera.height = GRAINY;
        ffp_image_free(&view->coverage);
        view->coverage = ffp_image_new(GRAINY, GRAINY, 1);
        for (int p = 0; p < many->n_patterns; p++) {
            ffp_image_free(&view->images[p]);
            view->images[p] = ffp_image_new(GRAINY, GRAINY, 3);
            for (int i = 0; i < 3 * GRAINY * GRAINY; i++)
                view->images[p].data[i] = (real)((seed = seed * 1664525 + 1013904223) >> 8) / (1 << 24);
        }
    }
}

// Where there is no room for all photographs, those under white become smaller.
static void test_every_view_has_a_photograph(void **state) {
    (void)state;
    static FfpCapture many; // `capture` leads to it if an assertion jumps out
    FfpCapture *small = capture;
    make_grainy(&many);
    capture = &many;
    const FfpPage how = {.size = sizeof how, .file = in_scratch("many.html"), .photographs = 512};
    const FfpPageStats stats = write_page(&how);
    capture = small;
    json_t *scene = json_loads(element("scene"), 0, NULL), *view;
    json_int_t bytes = 0;
    size_t v;
    json_array_foreach(json_object_get(scene, "views"), v, view) {
        const json_t *first = json_array_get(json_object_get(view, "photographs"), 0);
        assert_int_equal(json_integer_value(json_object_get(first, "pattern")), many.white);
        assert_in_range(json_integer_value(json_object_get(first, "size")), 50000, 1500000 / (MANY - 1));
        bytes += json_integer_value(json_object_get(first, "size"));
    }
    assert_int_equal(stats.photographs, MANY);
    assert_in_range(bytes, 1000000, 1500000);
    json_decref(scene);
    ffp_capture_free(&many);
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
        cmocka_unit_test(test_scattered_light_goes_along),
        cmocka_unit_test(test_photographs_are_left_out_when_asked),
        cmocka_unit_test(test_every_view_has_a_photograph),
        cmocka_unit_test(test_wrong_settings_are_refused),
    };
    const int failed = cmocka_run_group_tests(tests, setup, teardown);
    ffp_free(page);
    return failed;
}
