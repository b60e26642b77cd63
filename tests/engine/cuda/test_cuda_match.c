// The search for depth on a device against the CPU's, of objects, sizes and patterns by chance.
#include <math.h>
#include <string.h>
#include "compare.h"
#include "core/base/rng.h"
#include "engine/match/match.h"
#include "engine/match/search_there.h"
#include "world/synth/synth.h"

static const FfpDevice *device;

typedef struct Part { // of a picture
    int left, top, width, height;
} Part;

static void cut_image(FfpImage *image, const Part *part) {
    const size_t channels = (size_t)image->channels, row = (size_t)part->width * channels;
    for (int y = 0; y < part->height && image->data; y++)
        memmove(image->data + (size_t)y * row,
                image->data +
                    ((size_t)(y + part->top) * (size_t)image->width + (size_t)part->left) * channels,
                row * sizeof(real));
    image->width = part->width;
    image->height = part->height;
}

static void cut(FfpCapture *capture, const Part *part) {
    for (int v = 0; v < capture->n_views; v++) {
        FfpView *view = &capture->views[v];
        view->camera.width = part->width;
        view->camera.height = part->height;
        view->camera.cx -= (real)part->left;
        view->camera.cy -= (real)part->top;
        cut_image(&view->coverage, part);
        for (int p = 0; p < capture->n_patterns; p++) cut_image(&view->images[p], part);
    }
}

// Every third object fills all of its pictures, the others have room around them; of three views and more the
// last shows nothing.
static FfpCapture some_capture(uint64_t seed) {
    FfpCapture capture;
    FfpError err = {0};
    FfpRng rng = ffp_rng(seed, 0);
    FfpSceneSpec spec = ffp_scene_defaults();
    spec.seed = seed;
    spec.resolution = 24 + (int)ffp_rng_below(&rng, 24);
    spec.views = 1 + (int)ffp_rng_below(&rng, 4);
    spec.targets = 0, spec.lollipops = 2, spec.pattern_side = 64, spec.samples = 1, spec.ambient_rays = 1;
    if (!ffp_scene_make(&capture, &spec, &err)) fail_msg("%s", err.text);
    ffp_capture_estimate_bounds(&capture);
    const int side = spec.resolution, edge = seed % 3 == 0 ? side * 3 / 8 : 0;
    const int left = edge + (int)ffp_rng_below(&rng, 4), top = edge + (int)ffp_rng_below(&rng, 4);
    cut(&capture, &(Part){left, top, side - edge - left, side - edge - top});
    if (capture.n_views > 2) {
        FfpImage *none = &capture.views[capture.n_views - 1].coverage;
        memset(none->data, 0, (size_t)none->width * (size_t)none->height * sizeof(real));
    }
    const real centre[3] = {capture.centre[0], capture.centre[1], capture.centre[2]};
    ffp_capture_normalise(&capture, centre, capture.radius);
    return capture;
}

static FfpInitialisation start_of(const FfpCapture *capture, int n, const FfpDevice *by) {
    FfpError err = {0};
    FfpInitialisation start;
    FfpMatchSettings settings = ffp_match_defaults();
    const int patterns[] = {ffp_capture_find_pattern(capture, "lollipop_0"),
                            ffp_capture_find_pattern(capture, "lollipop_1")};
    settings.device = by;
    assert_true(ffp_can_search_there(capture, &settings) == (by != NULL));
    if (!ffp_initialisation_new(&start, capture, patterns, n, &settings, &err)) fail_msg("%s", err.text);
    assert_null(ffp_device());
    return start;
}

// The share of numbers that are farther apart than `most`.
static double share_apart(const real *a, const real *b, size_t count, double most) {
    size_t apart = 0;
    for (size_t i = 0; i < count; i++) apart += !(fabs((double)a[i] - (double)b[i]) <= most);
    return (double)apart / (double)count;
}

static void check(uint64_t seed, int n) {
    FfpCapture capture = some_capture(seed);
    FfpInitialisation here = start_of(&capture, n, NULL), there = start_of(&capture, n, device);
    const size_t count = (size_t)here.views * (size_t)here.width * (size_t)here.height;
    const double depth = share_apart(there.t, here.t, count, 1e-4),
                 trust = share_apart(there.confidence, here.confidence, count, 1e-3);
    size_t matched = 0;
    for (size_t i = 0; i < count; i++) matched += here.confidence[i] > 0;
    print_message(
        "%d views of %dx%d, %d patterns, %zu of %zu pixels matched: depths apart %.4f, trust %.4f\n",
        here.views, here.width, here.height, n, matched, count, depth, trust);
    assert_true(matched > 0);
    assert_true(depth <= 0.002 && trust <= 0.002);
    ffp_initialisation_free(&here);
    ffp_initialisation_free(&there);
    ffp_capture_free(&capture);
}

static void test_as_the_cpu(void **state) {
    (void)state;
    for (uint64_t seed = 1; seed <= 9; seed++) check(seed, 1 + (int)(seed % 2));
}

int main(void) {
    if (!(device = find_device())) return 0;
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_as_the_cpu)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
