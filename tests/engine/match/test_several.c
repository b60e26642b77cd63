// Matching with several patterns: costs add up, and what one pattern leaves open two together tell.
#include <math.h>
#include "core/base/alloc.h"
#include "engine/match/match.h"
#include "engine/match/sweep.h"
#include "support.h"

enum { BLACK, WHITE, COARSE, FINE, PATTERNS, WIDTH = 48, HEIGHT = 32, LIGHT_WIDTH = 160, LIGHT_HEIGHT = 120 };

#define FOCAL 60.0
#define LIGHT_FOCAL 120.0
#define BASELINE 0.6
#define FIRST_PERIOD 8.0  // pixels of the projector: three depths of the sphere look the same under one,
#define SECOND_PERIOD 6.0 // and another three under the other

static real stripe(double u, double period, int channel) {
    return (real)(0.5 + 0.5 * sin(2 * FFP_PI_DOUBLE * (u / period + channel / 3.0)));
}

static double period_of(int pattern) {
    return pattern == COARSE ? FIRST_PERIOD : SECOND_PERIOD;
}

static FfpImage pattern_image(int pattern) {
    FfpImage image = ffp_image_new(LIGHT_WIDTH, LIGHT_HEIGHT, 3);
    for (int i = 0; i < 3 * LIGHT_WIDTH * LIGHT_HEIGHT; i++)
        image.data[i] = pattern < COARSE ? (real)(pattern == WHITE)
                                         : stripe(i / 3 % LIGHT_WIDTH + 0.5, period_of(pattern), i % 3);
    return image;
}

// A board behind the sphere's middle, turned about the vertical.
static double true_depth(int x) {
    return 3.25 + 0.1 * ((x + 0.5 - WIDTH / 2.0) / FOCAL);
}

static FfpImage photograph_of(int pattern) {
    FfpImage image = ffp_image_new(WIDTH, HEIGHT, 3);
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        const int x = i % WIDTH;
        const double ray = (x + 0.5 - WIDTH / 2.0) / FOCAL;
        const double u = LIGHT_WIDTH / 2.0 + LIGHT_FOCAL * (ray - BASELINE / true_depth(x));
        for (int c = 0; c < 3; c++) {
            const real light = pattern < COARSE ? (real)(pattern == WHITE) : stripe(u, period_of(pattern), c);
            image.data[3 * i + c] = 0.05F + 0.5F * light;
        }
    }
    return image;
}

static FfpCamera device(double x, int width, int height, double focal) {
    return (FfpCamera){width,
                       height,
                       (real)focal,
                       (real)focal,
                       (real)width / 2,
                       (real)height / 2,
                       {1, 0, 0, (real)x, 0, 1, 0, 0, 0, 0, 1, -3, 0, 0, 0, 1}};
}

// The same board twice: the second view was photographed under the fine stripes alone.
static FfpCapture board(void) {
    FfpCapture capture = {.n_patterns = PATTERNS,
                          .n_views = 2,
                          .patterns = ffp_alloc(PATTERNS, sizeof *capture.patterns),
                          .views = ffp_alloc(2, sizeof *capture.views),
                          .black = BLACK,
                          .white = WHITE,
                          .intensity = {1, 1, 1},
                          .radius = 1};
    for (int p = 0; p < PATTERNS; p++) {
        capture.patterns[p].image = pattern_image(p);
        snprintf(capture.patterns[p].name, sizeof capture.patterns[p].name, "pattern %d", p);
    }
    for (int v = 0; v < 2; v++) {
        FfpView *view = &capture.views[v];
        view->camera = device(0, WIDTH, HEIGHT, FOCAL);
        view->projector = device(BASELINE, LIGHT_WIDTH, LIGHT_HEIGHT, LIGHT_FOCAL);
        view->coverage = ffp_image_new(WIDTH, HEIGHT, 1);
        for (int i = 0; i < WIDTH * HEIGHT; i++) view->coverage.data[i] = 1;
        view->images = ffp_alloc(PATTERNS, sizeof *view->images);
        for (int p = 0; p < PATTERNS; p++)
            if (v == 0 || p != COARSE) view->images[p] = photograph_of(p);
    }
    return capture;
}

// Share of the pixels, but those that the pattern's other side confuses, whose depth is right to 1 %.
static double right(const FfpCapture *capture, int view, const int *patterns, int n) {
    const FfpMatchSettings settings = ffp_match_defaults();
    real depth[WIDTH * HEIGHT];
    int good = 0;
    ffp_match_depth(capture, view, patterns, n, &settings, depth);
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        good += fabs((double)depth[i] - true_depth(i % WIDTH)) < 0.01 * true_depth(i % WIDTH);
    return (double)good / (WIDTH * HEIGHT);
}

static void two_patterns_tell_what_one_leaves_open(void **state) {
    (void)state;
    static const int both[] = {COARSE, FINE}, turned[] = {FINE, COARSE};
    FfpCapture capture = board();
    const double coarse = right(&capture, 0, both, 1), fine = right(&capture, 0, turned, 1),
                 together = right(&capture, 0, both, 2), the_other_way = right(&capture, 0, turned, 2);
    printf("right to 1 %%: %.2f and %.2f under one pattern, %.2f and %.2f under both\n", coarse, fine,
           together, the_other_way);
    assert_true(coarse < 0.6 && fine < 0.6);
    assert_true(together > 0.97 && the_other_way > 0.97);
    ffp_capture_free(&capture);
}

static void a_pattern_that_a_view_lacks_does_not_count(void **state) {
    (void)state;
    static const int both[] = {FINE, COARSE};
    const FfpMatchSettings settings = ffp_match_defaults();
    FfpCapture capture = board();
    real one[WIDTH * HEIGHT], two[WIDTH * HEIGHT];
    ffp_match_depth(&capture, 1, both, 1, &settings, one);
    ffp_match_depth(&capture, 1, both, 2, &settings, two);
    assert_memory_equal(one, two, sizeof one);
    ffp_match_depth(&capture, 0, both, 2, &settings, two);
    assert_memory_not_equal(one, two, sizeof one);
    FfpInitialisation start;
    FfpError err = {0};
    capture.n_views = 1;
    assert_true(ffp_initialisation_new(&start, &capture, both, 2, &settings, &err));
    ffp_initialisation_free(&start);
    capture.n_views = 2;
    assert_true(ffp_initialisation_new(&start, &capture, both, 2, &settings, &err));
    ffp_initialisation_free(&start);
    static const int lacking[] = {COARSE, FINE}; // the first is the one that every view must have
    assert_false(ffp_initialisation_new(&start, &capture, lacking, 2, &settings, &err));
    assert_non_null(strstr(err.text, "pattern 2"));
    FfpImage *image = &capture.views[0].images[COARSE]; // there, but of another size
    ffp_image_free(image);
    *image = ffp_image_new(WIDTH + 1, HEIGHT, 3);
    assert_false(ffp_initialisation_new(&start, &capture, both, 2, &settings, &err));
    assert_non_null(strstr(err.text, "pattern 2"));
    ffp_capture_free(&capture);
}

static real *swept(const FfpCapture *capture, int view, const int *patterns, int n, size_t *cells) {
    const FfpView *self = &capture->views[view];
    const FfpMatchSettings settings = ffp_match_defaults();
    const FfpPlanes planes = ffp_planes(capture, view, &settings);
    FfpForeground foreground = ffp_foreground_new(&self->coverage);
    FfpObservation seen = ffp_observe(capture, view, patterns, n);
    FfpBlurred blurred = ffp_blurred_new(capture, patterns, n, ffp_typical_footprint(capture, view));
    *cells = foreground.count * (size_t)planes.count;
    unsigned char *inside = ffp_alloc(*cells, 1);
    for (size_t i = 0; i < *cells; i++) inside[i] = i % 7 != 0;
    real *cost = ffp_alloc(*cells, sizeof *cost);
    ffp_sweep(cost, self, &foreground, &seen, &blurred, &planes, inside);
    ffp_free(inside);
    ffp_blurred_free(&blurred), ffp_observation_free(&seen), ffp_foreground_free(&foreground);
    return cost;
}

static void costs_of_patterns_add_up(void **state) {
    (void)state;
    static const int both[] = {COARSE, FINE};
    FfpCapture capture = board();
    size_t cells;
    real *sum = swept(&capture, 0, both, 2, &cells), *coarse = swept(&capture, 0, both, 1, &cells),
         *fine = swept(&capture, 0, both + 1, 1, &cells), *left = swept(&capture, 1, both, 2, &cells),
         *alone = swept(&capture, 1, both + 1, 1, &cells);
    double apart = 0;
    for (size_t i = 0; i < cells; i++) {
        assert_true(fabsf(sum[i] - (coarse[i] + fine[i])) < 1e-5F);
        apart += (double)fabsf(coarse[i] - fine[i]);
    }
    assert_true(apart > 0.1 * (double)cells);               // they are two patterns
    assert_memory_equal(left, alone, cells * sizeof *left); // where the first one asked for is missing
    ffp_free(sum), ffp_free(coarse), ffp_free(fine), ffp_free(left), ffp_free(alone);
    ffp_capture_free(&capture);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(costs_of_patterns_add_up),
                                       cmocka_unit_test(two_patterns_tell_what_one_leaves_open),
                                       cmocka_unit_test(a_pattern_that_a_view_lacks_does_not_count)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
