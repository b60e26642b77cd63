// The classical initialisation against the truth of the sample capture, and what it does with odd captures.
// Labels: threads
#include <math.h>
#include <omp.h>
#include "core/base/arena.h"
#include "core/base/vec.h"
#include "engine/match/derive.h"
#include "engine/match/match.h"
#include "engine/match/sweep.h"
#include "support.h"

#define SAMPLE FFP_SOURCE_DIR "/data/sample"

static FfpCapture open_capture(const char *path, int *active) {
    FfpError err = {0};
    FfpCapture capture;
    if (!ffp_capture_read(&capture, path, &err)) fail_msg("%s", err.text);
    const real centre[3] = {capture.centre[0], capture.centre[1], capture.centre[2]};
    ffp_capture_normalise(&capture, centre, capture.radius);
    *active = ffp_capture_active_pattern(&capture, "lollipop_0", &err);
    if (*active < 0) fail_msg("%s", err.text);
    return capture;
}

static FfpInitialisation start_of_several(const FfpCapture *capture, const int *patterns, int n) {
    FfpError err = {0};
    FfpInitialisation start;
    const FfpMatchSettings settings = ffp_match_defaults();
    if (!ffp_initialisation_new(&start, capture, patterns, n, &settings, &err)) fail_msg("%s", err.text);
    return start;
}

static FfpInitialisation start_of(const FfpCapture *capture, int active) {
    return start_of_several(capture, &active, 1);
}

static size_t count_of(const FfpInitialisation *start) {
    return (size_t)start->views * (size_t)start->width * (size_t)start->height;
}

// All maps from depths [views,height,width] (camera z, 0: none) that are given instead of matched.
static FfpInitialisation start_from_depth(const FfpCapture *capture, int active, const real *depth) {
    FfpInitialisation start = start_of(capture, active);
    const FfpMatchSettings settings = ffp_match_defaults();
    const size_t count = count_of(&start), area = count / (size_t)start.views;
    FfpDepths depths = {capture, start.width, start.height, ffp_alloc(count, sizeof(real)),
                        ffp_alloc(count, sizeof(real))};
    real *range = ffp_alloc(count, 2 * sizeof(real));
    for (int v = 0; v < capture->n_views; v++) ffp_hull_ranges(range + 2 * (size_t)v * area, capture, v);
    for (size_t i = 0; i < count; i++) {
        const bool known = depth[i] > 0 && capture->views[i / area].coverage.data[i % area] > 0;
        depths.depth[i] = known ? depth[i] : 0;
        depths.trust[i] = known ? 1 : 0;
    }
    ffp_derive(&start, &depths, range, NULL, &settings, 1);
    ffp_free(depths.depth);
    ffp_free(depths.trust);
    ffp_free(range);
    return start;
}

static const FfpView *view_of(const FfpCapture *capture, const FfpInitialisation *start, size_t i,
                              size_t *pixel) {
    const size_t area = (size_t)start->width * (size_t)start->height;
    *pixel = i % area;
    return &capture->views[i / area];
}

static int by_size(const void *a, const void *b) {
    const real x = *(const real *)a, y = *(const real *)b;
    return (x > y) - (x < y);
}

// Median and 90th percentile of |camera z - truth| in % of the radius, over whole pixels, matched or filled
// ones.
static void depth_errors(const FfpCapture *capture, const FfpInitialisation *start, bool matched,
                         double figures[2]) {
    real *errors = ffp_alloc(count_of(start), sizeof *errors);
    size_t count = 0;
    for (size_t i = 0; i < count_of(start); i++) {
        size_t p;
        const FfpView *view = view_of(capture, start, i, &p);
        if (view->coverage.data[p] < 1 || view->depth.data[p] <= 0 || (start->confidence[i] > 0) != matched)
            continue;
        errors[count++] = fabsf(start->footprint[i] * view->camera.fx - view->depth.data[p]) * 100;
    }
    assert_true(count > 0);
    qsort(errors, count, sizeof *errors, by_size);
    figures[0] = (double)errors[count / 2], figures[1] = (double)errors[count * 9 / 10];
    printf("%s, %s: median %.3f %%, nine in ten within %.2f %% of the radius (%zu pixels)\n", capture->name,
           matched ? "matched" : "filled", figures[0], figures[1], count);
    ffp_free(errors);
}

static void assert_share(real value) {
    assert_true(value >= 0 && value <= 1);
}

// The promises of match.h for every pixel.
static void check_maps(const FfpCapture *capture, const FfpInitialisation *start) {
    size_t shown = 0;
    for (size_t i = 0; i < count_of(start); i++) {
        size_t p;
        const FfpView *view = view_of(capture, start, i, &p);
        const real *normal = start->normal + 3 * i;
        assert_share(start->confidence[i]), assert_share(start->lit[i]), assert_share(start->coverage[i]);
        assert_share(start->agreement[i]), assert_share(start->violation[i]);
        assert_true(start->coverage[i] <= view->coverage.data[p]);
        for (int c = 0; c < 3; c++)
            assert_true(isfinite(start->ambient[3 * i + (size_t)c]) &&
                        start->ambient[3 * i + (size_t)c] >= 0),
                assert_share(start->albedo[3 * i + (size_t)c]);
        if (view->coverage.data[p] <= 0) {
            assert_true(start->t[i] == 0 && start->footprint[i] == 0 && ffp_dot3(normal, normal) == 0);
            continue;
        }
        real ray[3];
        const real along = ffp_pixel_ray(&view->camera, (real)(p % (size_t)start->width) + 0.5F,
                                         (real)(p / (size_t)start->width) + 0.5F, ray);
        assert_true(start->t[i] > 0 && isfinite(start->t[i]));
        assert_true(fabsf(start->footprint[i] * view->camera.fx - start->t[i] * along) < 1e-4F * start->t[i]);
        assert_true(fabsf(ffp_dot3(normal, normal) - 1) < 1e-4F && ffp_dot3(normal, ray) < 0);
        shown += start->coverage[i] > 0;
    }
    assert_true(shown > 0);
}

static void test_the_sample(void **state) {
    (void)state;
    int active;
    FfpCapture capture = open_capture(SAMPLE, &active);
    FfpInitialisation start = start_of(&capture, active);
    double matched[2], filled[2];
    check_maps(&capture, &start);
    depth_errors(&capture, &start, true, matched);
    depth_errors(&capture, &start, false, filled);
    assert_true(matched[0] < 0.3 && matched[1] < 1);
    assert_true(filled[0] < 1.5 && filled[1] < 10); // 14 without a look at the pictures under black
    ffp_initialisation_free(&start);
    ffp_capture_free(&capture);
}

static void enlarge(FfpImage *image, int times) {
    if (!image->data) return;
    const FfpImage larger = ffp_image_resize(image, times * image->width, times * image->height);
    ffp_image_free(image);
    *image = larger;
}

static void enlarge_capture(FfpCapture *capture, int times) {
    for (int v = 0; v < capture->n_views; v++) {
        FfpView *view = &capture->views[v];
        for (int p = 0; p < capture->n_patterns; p++) enlarge(&view->images[p], times);
        enlarge(&view->coverage, times), enlarge(&view->depth, times);
        view->camera.width *= times, view->camera.height *= times;
        view->camera.fx *= (real)times, view->camera.fy *= (real)times;
        view->camera.cx *= (real)times, view->camera.cy *= (real)times;
    }
}

// The sample with more pixels is matched on reduced pictures, and found as well as the sample itself.
static void test_depth_of_a_large_capture(void **state) {
    (void)state;
    int active;
    FfpCapture capture = open_capture(SAMPLE, &active);
    enlarge_capture(&capture, 4);
    FfpInitialisation start = start_of(&capture, active);
    assert_non_null(start.reduced);
    check_maps(&capture, &start);
    double matched[2], filled[2];
    depth_errors(&capture, &start, true, matched);
    depth_errors(&capture, &start, false, filled);
    assert_true(matched[0] < 0.3 && matched[1] < 1.2);
    assert_true(filled[0] < 1.5 && filled[1] < 10);
    ffp_initialisation_free(&start);
    ffp_capture_free(&capture);
}

static void compare_patterns(const FfpCapture *capture, const int *patterns) {
    double one[2], three[2];
    FfpInitialisation start = start_of(capture, patterns[0]);
    depth_errors(capture, &start, true, one);
    ffp_initialisation_free(&start);
    start = start_of_several(capture, patterns, 3);
    check_maps(capture, &start);
    depth_errors(capture, &start, true, three);
    ffp_initialisation_free(&start);
    assert_true(three[0] < 0.95 * one[0] && three[1] < 0.95 * one[1]);
}

// Depth under three patterns is nearer to the truth than under one of them, in pictures of either size.
static void test_more_patterns_come_closer(void **state) {
    (void)state;
    int patterns[3];
    FfpCapture capture = open_capture(SAMPLE, &patterns[0]);
    patterns[1] = ffp_capture_find_pattern(&capture, "lollipop_2");
    patterns[2] = ffp_capture_find_pattern(&capture, "lollipop_4");
    compare_patterns(&capture, patterns);
    enlarge_capture(&capture, 3);
    compare_patterns(&capture, patterns);
    ffp_capture_free(&capture);
}

static void test_depth_of_shared_captures(void **state) {
    (void)state;
    SAME_WAY_AGAIN(); // test_the_sample
    static const char *names[] = {"captures/teapot", "captures/suzanne", "captures/cow"};
    for (int i = 0; i < 3; i++) {
        char path[1024];
        if (!shared_path(path, names[i])) skip();
        int active;
        FfpCapture capture = open_capture(path, &active);
        FfpInitialisation start = start_of(&capture, active);
        double matched[2];
        depth_errors(&capture, &start, true, matched);
        assert_true(matched[0] < 0.5 && matched[1] < 2);
        ffp_initialisation_free(&start);
        ffp_capture_free(&capture);
    }
}

static void test_same_bits_for_any_thread_count(void **state) {
    (void)state;
    int active;
    FfpCapture capture = open_capture(SAMPLE, &active);
    const int threads = omp_get_max_threads();
    omp_set_num_threads(1);
    FfpInitialisation one = start_of(&capture, active);
    omp_set_num_threads(3);
    FfpInitialisation three = start_of(&capture, active);
    omp_set_num_threads(threads);
    assert_memory_equal(one.t, three.t, count_of(&one) * sizeof(real));
    assert_memory_equal(one.confidence, three.confidence, count_of(&one) * sizeof(real));
    assert_memory_equal(one.albedo, three.albedo, 3 * count_of(&one) * sizeof(real));
    ffp_initialisation_free(&one), ffp_initialisation_free(&three);
    ffp_capture_free(&capture);
}

static void test_from_depth(void **state) {
    (void)state;
    int active;
    FfpCapture capture = open_capture(SAMPLE, &active);
    const size_t area = (size_t)capture.views[0].camera.width * (size_t)capture.views[0].camera.height;
    real *depth = ffp_alloc(area * (size_t)capture.n_views, sizeof *depth);
    for (int v = 0; v < capture.n_views; v++)
        memcpy(depth + (size_t)v * area, capture.views[v].depth.data, area * sizeof *depth);
    FfpInitialisation start = start_from_depth(&capture, active, depth);
    check_maps(&capture, &start);
    double violated = 0, seen = 0;
    for (size_t i = 0; i < count_of(&start); i++) {
        size_t p;
        const FfpView *view = view_of(&capture, &start, i, &p);
        if (depth[i] <= 0 || view->coverage.data[p] <= 0) continue;
        assert_true(fabsf(start.footprint[i] * view->camera.fx - depth[i]) < 1e-4F);
        if (view->coverage.data[p] == 1) violated += start.violation[i] > 0, seen++;
    }
    assert_true(violated < 0.02 * seen); // the truth does not contradict itself
    ffp_free(depth);
    ffp_initialisation_free(&start);
    ffp_capture_free(&capture);
}

static void flat_image(FfpImage *image, int width, int height, int channels, real value) {
    *image = ffp_image_new(width, height, channels);
    for (size_t i = 0; i < (size_t)width * (size_t)height * (size_t)channels; i++) image->data[i] = value;
}

// A capture of `n_views` alike views made of flat pictures.
static FfpCapture flat_capture(int n_views, int width, int height, real light, real coverage) {
    FfpCapture capture = {
        .n_patterns = 3, .n_views = n_views, .black = 0, .white = 1, .intensity = {8, 8, 8}, .radius = 1};
    capture.patterns = ffp_alloc(3, sizeof *capture.patterns);
    capture.views = ffp_alloc((size_t)n_views, sizeof *capture.views);
    for (int p = 0; p < 3; p++) flat_image(&capture.patterns[p].image, 16, 16, 3, p == 1 ? 1 : 0);
    for (int v = 0; v < n_views; v++) {
        FfpView *view = &capture.views[v];
        const FfpCamera camera = {width,
                                  height,
                                  20,
                                  20,
                                  (real)width / 2,
                                  (real)height / 2,
                                  {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, -3, 0, 0, 0, 1}};
        view->camera = view->projector = camera;
        view->projector.width = view->projector.height = 16;
        view->projector.pose[3] = 0.5F;
        view->images = ffp_alloc(3, sizeof *view->images);
        for (int p = 0; p < 3; p++)
            flat_image(&view->images[p], width, height, 3, p == 1 ? 0.2F + light : 0.2F);
        flat_image(&view->coverage, width, height, 1, coverage);
    }
    return capture;
}

// The share of pixel (x, y) that a disc of radius r about (c, c) fills, by 16 x 16 samples.
static real disc_share(int x, int y, real c, real r) {
    int inside = 0;
    for (int s = 0; s < 256; s++) {
        const real dx = (real)x + ((real)(s % 16) + 0.5F) / 16 - c,
                   dy = (real)y + ((real)(s / 16) + 0.5F) / 16 - c;
        inside += dx * dx + dy * dy < r * r;
    }
    return (real)inside / 256;
}

// A flat capture of one view, far away, that shows a disc of an even colour, as photographs show it: encoded
// values times coverage.
static FfpCapture disc_capture(void) {
    static const real shade[3][3] = {{0.05F, 0.2F, 0.1F}, {0.35F, 0.5F, 0.25F}, {0.1F, 0.3F, 0.2F}};
    FfpCapture capture = flat_capture(1, 16, 16, 0, 0);
    FfpView *view = &capture.views[0];
    view->camera.fx = view->camera.fy = 400;
    for (int i = 0; i < 256; i++) {
        const real share = disc_share(i % 16, i / 16, 8.2F, 5);
        view->coverage.data[i] = share;
        for (int p = 0; p < 3; p++)
            for (int c = 0; c < 3; c++)
                view->images[p].data[3 * i + c] = ffp_srgb_decode(share * ffp_srgb_encode(shade[p][c]));
    }
    return capture;
}

// Colours of pixels that the object fills in part are those of the pixels it fills.
static void test_colours_at_the_outline(void **state) {
    (void)state;
    FfpCapture capture = disc_capture();
    real depth[256];
    for (int i = 0; i < 256; i++) depth[i] = 3;
    FfpInitialisation start = start_from_depth(&capture, 2, depth);
    const real *ambient = start.ambient + (ptrdiff_t)3 * (8 * 16 + 8),
               *albedo = start.albedo + (ptrdiff_t)3 * (8 * 16 + 8);
    int rim = 0;
    for (int i = 0; i < 256; i++) {
        const real share = capture.views[0].coverage.data[i];
        for (int c = 0; c < 3 && share > 0.1F; c++) {
            assert_true(fabsf(start.ambient[3 * i + c] - ambient[c]) < 1e-3F);
            assert_true(fabsf(start.albedo[3 * i + c] - albedo[c]) < 0.02F * albedo[c]);
        }
        rim += share > 0.1F && share < 0.9F;
    }
    assert_true(rim > 20);
    ffp_initialisation_free(&start);
    ffp_capture_free(&capture);
}

static void test_odd_captures(void **state) {
    (void)state;
    static const struct {
        int views, width, height;
        real light;
    } cases[] = {{1, 1, 1, 0.3F}, {2, 1, 7, 0}, {3, 9, 2, 0.3F}, {1, 13, 11, 0}, {2, 5, 5, -0.1F}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        FfpCapture capture = flat_capture(cases[i].views, cases[i].width, cases[i].height, cases[i].light, 1);
        FfpInitialisation start = start_of(&capture, 2);
        check_maps(&capture, &start);
        ffp_initialisation_free(&start);
        ffp_capture_free(&capture);
    }
    FfpCapture empty = flat_capture(2, 6, 5, 0.3F, 0); // no object at all
    FfpInitialisation start = start_of(&empty, 2);
    for (size_t i = 0; i < count_of(&start); i++) assert_true(start.t[i] == 0 && start.coverage[i] == 0);
    ffp_initialisation_free(&start);
    ffp_capture_free(&empty);
}

static void expect_refused(FfpCapture *capture, int active, const char *word) {
    FfpError err = {0};
    FfpInitialisation start;
    const FfpMatchSettings settings = ffp_match_defaults();
    assert_false(ffp_initialisation_new(&start, capture, &active, 1, &settings, &err));
    if (!strstr(err.text, word)) fail_msg("no \"%s\" in: %s", word, err.text);
    assert_null(start.t);
    ffp_capture_free(capture);
}

static void test_refusals(void **state) {
    (void)state;
    FfpCapture capture = flat_capture(2, 6, 5, 0.3F, 1);
    capture.views[1].camera.width = 7;
    expect_refused(&capture, 2, "size");
    capture = flat_capture(2, 6, 5, 0.3F, 1);
    ffp_image_free(&capture.views[1].images[capture.white]);
    expect_refused(&capture, 2, "white");
    capture = flat_capture(2, 6, 5, 0.3F, 1);
    ffp_image_free(&capture.views[0].images[2]);
    strcpy(capture.patterns[2].name, "stripes");
    expect_refused(&capture, 2, "stripes");
    capture = flat_capture(1, 6, 5, 0.3F, 1);
    expect_refused(&capture, 3, "pattern");
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_the_sample),
                                       cmocka_unit_test(test_depth_of_a_large_capture),
                                       cmocka_unit_test(test_more_patterns_come_closer),
                                       cmocka_unit_test(test_depth_of_shared_captures),
                                       cmocka_unit_test(test_same_bits_for_any_thread_count),
                                       cmocka_unit_test(test_from_depth),
                                       cmocka_unit_test(test_colours_at_the_outline),
                                       cmocka_unit_test(test_odd_captures),
                                       cmocka_unit_test(test_refusals)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
