// Captures that are right: both layouts, coverage, bounds, intensity, normalising, writing and reading back.
// Labels: threads
#include <math.h>
#include "core/base/alloc.h"
#include "core/base/vec.h"
#include "core/capture/photographs.h"
#include "core/capture/reduce.h"
#include "tiny_capture.h"

static void assert_near(double got, double want, double tolerance) {
    if (!(fabs(got - want) <= tolerance)) fail_msg("%.9g is not %.9g", got, want);
}

static void scene_is_read(void **state) {
    (void)state;
    FfpCapture capture;
    FfpError err = {0};
    if (!ffp_capture_read(&capture, scratch, &err)) fail_msg("%s", err.text);
    assert_string_equal(capture.name, "tiny");
    assert_int_equal(capture.n_views, 2);
    assert_int_equal(capture.n_patterns, 4);
    assert_int_equal(capture.black, 0);
    assert_int_equal(capture.white, 1);
    assert_true(capture.patterns[2].novel && !capture.patterns[3].novel);
    assert_near(capture.radius, 0.5, 0);
    assert_true(capture.intensity_known && capture.intensity[1] == 8);
    const FfpView *a = &capture.views[0], *b = &capture.views[1];
    assert_true(a->camera.width == 12 && a->camera.height == 10 && a->camera.fy == 21 &&
                a->camera.cy == -5.5F);
    assert_true(a->camera.fx == 20 && b->camera.fx == 25 && b->camera.fy == 21);
    assert_true(a->projector.width == 16 && a->projector.height == 9 && a->projector.cy == 14);
    assert_null(b->images[2].data); // "earth" was not shown there
    assert_null(a->depth.data);
    assert_near(a->images[1].data[3 * (5 * 12 + 6) + 1], ffp_srgb_decode(170.F / 255),
                1e-6);                       // 2/3 at the middle
    assert_near(a->images[1].data[0], 0, 0); // alpha 0 at the corner
    assert_true(a->coverage.data[0] == 0 && a->coverage.data[5 * 12 + 6] == 1);
    assert_near(capture.patterns[0].image.data[5], 0, 0); // black and white without files
    assert_near(capture.patterns[1].image.data[5], 1, 0);
    assert_int_equal(ffp_capture_find_view(&capture, "b"), 1);
    assert_int_equal(ffp_capture_find_view(&capture, "c"), -1);
    ffp_capture_free(&capture);
    ffp_capture_free(&capture);
    assert_true(ffp_capture_read(&capture, in_scratch("scene.json"), &err)); // a file as well as a folder
    ffp_capture_free(&capture);
}

// A scene keeps that it is one, and how deep its views look.
static void whole_scenes_are_written_and_read_back(void **state) {
    (void)state;
    FfpCapture capture, back;
    FfpError err = {0};
    char *text = replaced(scene_text, "\"name\": \"tiny\"", "\"scene\": true");
    char *whole = replaced(text, "{\"id\": \"a\"", "{\"range\": [1.5, 40], \"id\": \"a\"");
    write_text("whole.json", whole);
    if (!ffp_capture_read(&capture, in_scratch("whole.json"), &err)) fail_msg("%s", err.text);
    assert_true(capture.scene && capture.views[0].near == 1.5F && capture.views[0].far == 40);
    // Nothing is lit, so the other view's are as wide as can be.
    assert_true(capture.views[1].near > 0 && capture.views[1].far > 10 * capture.views[1].near);
    if (!ffp_capture_write(&capture, in_scratch("whole"), &err)) fail_msg("%s", err.text);
    if (!ffp_capture_read(&back, in_scratch("whole"), &err)) fail_msg("%s", err.text);
    assert_true(back.scene && back.views[0].near == 1.5F && back.views[0].far == 40);
    const real centre[3] = {0, 0, 0};
    ffp_capture_normalise(&back, centre, 0.5F);
    assert_true(back.views[0].near == 3 && back.views[0].far == 80);
    ffp_capture_free(&back);
    ffp_capture_free(&capture);
    ffp_free(whole);
    ffp_free(text);
}

static void names_are_listed_as_far_as_they_fit(void **state) {
    (void)state;
    static FfpView views[100];
    const FfpCapture capture = {.n_views = 100, .views = views};
    for (int v = 0; v < 100; v++) snprintf(views[v].id, sizeof views[v].id, "view_%04d", v);
    const FfpListed listed = ffp_list_views(&capture);
    assert_int_equal(strncmp(listed.text, "view_0000, view_0001, ", 22), 0);
    const char *more = strstr(listed.text, " and ");
    assert_non_null(more);
    char last[64]; // as many as are told are left out
    const int left = (int)strtol(more + 5, NULL, 10);
    snprintf(last, sizeof last, "view_%04d and %d more", 99 - left, left);
    assert_string_equal(more - strlen("view_0000"), last);
}

// As editors on Windows save it.
static void scene_with_a_byte_order_mark_is_read(void **state) {
    (void)state;
    FfpCapture capture;
    FfpError err = {0};
    char *text = replaced(scene_text, "{", "\xEF\xBB\xBF{");
    write_text("marked.json", text);
    ffp_free(text);
    if (!ffp_capture_read(&capture, in_scratch("marked.json"), &err)) fail_msg("%s", err.text);
    assert_string_equal(capture.name, "tiny");
    ffp_capture_free(&capture);
}

static void active_pattern_is_found(void **state) {
    (void)state;
    FfpCapture capture;
    FfpError err = {0};
    assert_true(ffp_capture_read(&capture, scratch, &err));
    assert_int_equal(ffp_capture_active_pattern(&capture, NULL, &err), 3);
    assert_int_equal(ffp_capture_active_pattern(&capture, "dots", &err), 3);
    assert_int_equal(ffp_capture_active_pattern(&capture, "earth", &err), -1);
    assert_string_equal(err.text, "view 'b' has no picture under pattern 'earth' (tiny)");
    assert_int_equal(ffp_capture_active_pattern(&capture, "stripes", &err), -1);
    assert_non_null(strstr(err.text, "no pattern 'stripes'"));
    assert_int_equal(ffp_capture_active_pattern(&capture, "bright", &err), -1);
    assert_non_null(strstr(err.text, "is uniform"));
    capture.patterns[3].novel = true;
    assert_int_equal(ffp_capture_active_pattern(&capture, NULL, &err), -1);
    ffp_capture_free(&capture);
}

static void render_poses_are_read(void **state) {
    (void)state;
    FfpCapture capture;
    FfpError err = {0};
    write_text("render_poses.json", poses_text);
    FfpImage depth = ffp_image_new(12, 10, 1);
    for (int i = 0; i < 120; i++) depth.data[i] = i == 7 ? 1 : 2500.F / 65535;
    assert_true(ffp_image_write_png16(&depth, in_scratch("a_depth.png"), NULL));
    ffp_image_free(&depth);
    if (!ffp_capture_read(&capture, in_scratch("render_poses.json"), &err)) fail_msg("%s", err.text);
    assert_true(capture.black == 0 && capture.white == 1);
    assert_true(capture.patterns[2].novel && !capture.patterns[3].novel);
    assert_near(capture.intensity[0], 7.9577472, 1e-5);
    const FfpView *view = &capture.views[0];
    // Blender's camera at (3,0,0) looks along -z of its own, so towards -x; its y is the world's z.
    const real want[16] = {0, 0, -1, 3, 1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 0, 1};
    for (int i = 0; i < 16; i++) assert_near(view->camera.pose[i], want[i], 1e-7);
    assert_near(view->depth.data[0], 2.5, 1e-6);
    assert_near(view->depth.data[7], 0, 0);
    assert_true(view->projector.width == 16 && view->projector.height == 9); // from the patterns
    ffp_capture_free(&capture);
    assert_int_equal(unlink(in_scratch("a_depth.png")), 0);
}

static void unknown_intensity_is_estimated(void **state) {
    (void)state;
    FfpCapture capture;
    char *text = replaced(scene_text, "\"intensity\": [7, 8, 9]", "\"intensity\": null");
    write_text("unknown.json", text);
    ffp_free(text);
    assert_true(ffp_capture_read(&capture, in_scratch("unknown.json"), NULL));
    assert_false(capture.intensity_known);
    // All lit pixels are alike, so the percentile is that of the three channels: the brightest, d^2 = 5.
    const double brightest = 1 - (double)ffp_srgb_decode(51.F / 255);
    assert_near(capture.intensity[0], 3.14159265 * 5 * brightest / 0.8, 1e-3);
    assert_true(capture.intensity[0] == capture.intensity[2]);
    ffp_capture_free(&capture);
}

// Three discs without alpha: a mask file covers and crops; without one, what white brightens is taken.
static void coverage_has_other_sources(void **state) {
    (void)state;
    FfpImage image = ffp_image_new(12, 10, 3), mask = ffp_image_new(12, 10, 1);
    for (int k = 0; k < 2; k++) {
        for (int i = 0; i < 120; i++) {
            for (int c = 0; c < 3; c++) image.data[3 * i + c] = k == 1 && i % 12 < 6 ? 0.8F : 0.4F;
            mask.data[i] = i % 12 < 3 ? 1 : 0;
        }
        assert_true(ffp_image_write_png(&image, in_scratch(k == 0 ? "o0.png" : "o1.png"), NULL));
    }
    assert_true(ffp_image_write_png(&mask, in_scratch("a_mask.png"), NULL));
    char *text = replaced(poses_text, "/far/away/a0.png", "o0.png"),
         *opaque = replaced(text, "a1.png", "o1.png");
    ffp_free(text);
    text = replaced(opaque, "../a2.png", "o1.png");
    ffp_free(opaque);
    opaque = replaced(text, "\"a2.png\"", "\"o1.png\"");
    ffp_free(text);
    write_text("opaque.json", opaque);
    ffp_free(opaque);
    FfpCapture capture;
    assert_true(ffp_capture_read(&capture, in_scratch("opaque.json"), NULL));
    for (int i = 0; i < 120; i++) {
        assert_near(capture.views[0].coverage.data[i], i % 12 < 3, 0);
        assert_near(capture.views[0].images[0].data[3 * i], i % 12 < 3 ? ffp_srgb_decode(0.4F) : 0, 1e-6);
    }
    ffp_capture_free(&capture);
    assert_int_equal(unlink(in_scratch("a_mask.png")), 0);
    assert_true(ffp_capture_read(&capture, in_scratch("opaque.json"), NULL));
    for (int i = 0; i < 120; i++) {
        assert_near(capture.views[0].coverage.data[i], i % 12 < 6, 0);
        assert_near(capture.views[0].images[0].data[3 * i], ffp_srgb_decode(0.4F), 1e-6);
    }
    assert_true(ffp_capture_write(&capture, in_scratch("opaque"), NULL)); // the background must survive
    ffp_capture_free(&capture);
    assert_true(ffp_capture_read(&capture, in_scratch("opaque"), NULL));
    assert_near(capture.views[0].images[0].data[3 * 11], ffp_srgb_decode(0.4F), 1e-6);
    assert_near(capture.views[0].coverage.data[11], 0, 0);
    ffp_capture_free(&capture);
    ffp_image_free(&image);
    ffp_image_free(&mask);
}

static void assert_same_image(const FfpImage *a, const FfpImage *b, double tolerance) {
    assert_int_equal(!a->data, !b->data);
    if (!a->data) return;
    assert_true(a->width == b->width && a->height == b->height && a->channels == b->channels);
    for (int i = 0; i < a->width * a->height * a->channels; i++)
        assert_near(a->data[i], b->data[i], tolerance);
}

static void add_truth(FfpView *view, uint64_t seed) {
    FfpRng rng = ffp_rng(seed, 0);
    FfpImage *const images[5] = {&view->depth, &view->normal, &view->albedo, &view->roughness,
                                 &view->direct_white};
    static const int channels[5] = {1, 3, 3, 1, 3};
    for (int k = 0; k < 5; k++) {
        *images[k] = ffp_image_new(view->camera.width, view->camera.height, channels[k]);
        for (int i = 0; i < view->camera.width * view->camera.height * channels[k]; i++) {
            images[k]->data[i] = ffp_rng_uniform(&rng);
        }
    }
    for (int i = 0; i < view->camera.width * view->camera.height; i++)
        ffp_normalise3(view->normal.data + 3 * i);
}

static void written_capture_comes_back(void **state) {
    (void)state;
    FfpCapture capture, back;
    FfpError err = {0};
    assert_true(ffp_capture_read(&capture, scratch, &err));
    assert_false(capture.panel.known);
    capture.panel = (FfpPanel){true,  1920,
                               1080,  2210.5F,
                               2208,  958.2F,
                               1100,  {0.1F, -0.2F, 0, 0.01F, 0},
                               true,  {2.2F, 2.1F, 1},
                               1.25F, {0.04F, 0.02F, 0.5F},
                               31};
    add_truth(&capture.views[1], 5);
    write_text("stale.txt", "x");
    if (!ffp_capture_write(&capture, in_scratch("copy/of it"), &err)) fail_msg("%s", err.text);
    if (!ffp_capture_read(&back, in_scratch("copy/of it"), &err)) fail_msg("%s", err.text);
    assert_string_equal(back.name, capture.name);
    assert_true(back.n_views == 2 && back.n_patterns == 4 && back.black == 0 && back.white == 1);
    assert_true(back.patterns[2].novel && !back.patterns[3].novel);
    assert_true(back.radius == capture.radius && back.intensity[2] == capture.intensity[2] &&
                back.intensity_known);
    for (int i = 0; i < 4; i++) assert_same_image(&back.patterns[i].image, &capture.patterns[i].image, 1e-6);
    const FfpPanel *panel = &back.panel;
    assert_true(panel->known && panel->width == 1920 && panel->height == 1080 && panel->power);
    assert_true(panel->fx == 2210.5F && panel->fy == 2208 && panel->cx == 958.2F && panel->cy == 1100);
    assert_memory_equal(panel->lens, capture.panel.lens, sizeof panel->lens);
    assert_memory_equal(panel->gamma, capture.panel.gamma, sizeof panel->gamma);
    assert_true(panel->blur == 1.25F && panel->spread_reach == 31);
    assert_memory_equal(panel->spread, capture.panel.spread, sizeof panel->spread);
    for (int v = 0; v < 2; v++) {
        const FfpView *a = &capture.views[v], *b = &back.views[v];
        assert_string_equal(a->id, b->id);
        assert_true(a->camera.fx == b->camera.fx && a->projector.cy == b->projector.cy);
        for (int i = 0; i < 16; i++) {
            assert_near(b->camera.pose[i], a->camera.pose[i], 1e-7);
            assert_near(b->projector.pose[i], a->projector.pose[i], 1e-7);
        }
        for (int i = 0; i < 4; i++) assert_same_image(&b->images[i], &a->images[i], 1e-6);
        assert_same_image(&b->coverage, &a->coverage, 0);
        assert_same_image(&b->depth, &a->depth, 1e-7);
        assert_same_image(&b->normal, &a->normal, 1e-7);
        assert_same_image(&b->albedo, &a->albedo, 1e-7);
        assert_same_image(&b->roughness, &a->roughness, 1e-7);
        assert_same_image(&b->direct_white, &a->direct_white, 1e-7);
    }
    ffp_capture_free(&back);
    strcpy(capture.patterns[3].name, "x_earth"); // "a" + "x_earth" and "a_x" + "earth" would be one file
    strcpy(capture.views[1].id, "a_x");
    capture.views[1].images[2] = ffp_image_copy(&capture.views[1].images[1]);
    assert_false(ffp_capture_write(&capture, in_scratch("copy/of it"), &err));
    assert_non_null(strstr(err.text, "two images would have this name"));
    assert_false(ffp_is_file(in_scratch("copy/of it/scene.json"))); // half of a capture is none
    ffp_capture_free(&capture);
}

static void targets_share_patterns(void **state) {
    (void)state;
    FfpCapture capture, targets;
    FfpError err = {0};
    assert_true(ffp_capture_read(&capture, scratch, &err));
    char *text = replaced(poses_text, "all_black", "dark"), *poses = replaced(text, "all_white", "bright");
    write_text("targets.json", poses);
    if (!ffp_capture_read_targets(&targets, scratch, &capture, &err)) fail_msg("%s", err.text);
    assert_int_equal(targets.n_patterns, 6); // the capture's four, nature, lollipop_0
    for (int i = 0; i < 4; i++) assert_string_equal(targets.patterns[i].name, capture.patterns[i].name);
    assert_true(targets.black == 0 && targets.white == 1 && targets.n_views == 1);
    assert_true(targets.views[0].images[0].data && !targets.views[0].images[2].data);
    assert_true(targets.radius == capture.radius && targets.intensity[0] == 7);
    ffp_capture_free(&targets);
    ffp_free(poses);
    ffp_free(text);
    // Poses without any picture.
    char *end = replaced(poses_text, "\"patterns\": [", "\"other\": [");
    write_text("bare.json", end);
    if (!ffp_capture_read_targets(&targets, in_scratch("bare.json"), &capture, &err))
        fail_msg("%s", err.text);
    assert_true(targets.n_patterns == 4 && targets.views[0].coverage.data);
    for (int i = 0; i < 120; i++) assert_near(targets.views[0].coverage.data[i], 0, 0);
    ffp_capture_free(&targets);
    ffp_free(end);
    ffp_capture_free(&capture);
}

static void normalising_keeps_the_light(void **state) {
    (void)state;
    FfpCapture capture;
    assert_true(ffp_capture_read(&capture, scratch, NULL));
    add_truth(&capture.views[0], 1);
    const real depth = capture.views[0].depth.data[3], centre[3] = {0.1F, -0.2F, 0.3F};
    const real point[3] = {0.2F, 0.1F, 0};
    real x0, y0, x1, y1, inside[3];
    const real z0 = ffp_project(&capture.views[0].camera, point, &x0, &y0);
    ffp_capture_normalise(&capture, centre, 0.5F);
    for (int i = 0; i < 3; i++) inside[i] = (point[i] - centre[i]) / 0.5F;
    const real z1 = ffp_project(&capture.views[0].camera, inside, &x1, &y1);
    assert_near(x1, x0, 1e-4);
    assert_near(y1, y0, 1e-4);
    assert_near(z1, z0 / 0.5F, 1e-5);
    assert_near(capture.views[0].depth.data[3], depth / 0.5F, 1e-6);
    assert_near(capture.intensity[0], 28, 1e-4);
    assert_true(capture.radius == 1 && capture.centre[0] == 0);
    ffp_capture_normalise(&capture, capture.centre, capture.radius); // once more changes nothing
    assert_near(capture.intensity[0], 28, 1e-4);
    ffp_capture_free(&capture);
}

static void bounds_meet_the_axes(void **state) {
    (void)state;
    FfpCapture capture;
    assert_true(ffp_capture_read(&capture, scratch, NULL));
    ffp_capture_estimate_bounds(&capture);
    // Cameras look along -x and -y at height 0, projectors likewise at height 1: the nearest point is (0, 0,
    // 1/2).
    assert_near(capture.centre[0], 0, 1e-6);
    assert_near(capture.centre[1], 0, 1e-6);
    assert_near(capture.centre[2], 0.5, 1e-6);
    assert_true(capture.radius > 0.5);
    // All devices side by side with parallel axes: the centre is somewhere ahead of them.
    for (int v = 0; v < 2; v++) {
        for (int i = 0; i < 16; i++) {
            capture.views[v].camera.pose[i] = capture.views[v].projector.pose[i] = i % 5 == 0;
        }
        capture.views[v].camera.pose[3] = (real)v;
    }
    ffp_capture_estimate_bounds(&capture);
    assert_true(isfinite(capture.centre[0]) && capture.centre[2] > 0 && isfinite(capture.radius) &&
                capture.radius > 0);
    ffp_capture_free(&capture);
}

static void pixels_and_points_agree(void **state) {
    (void)state;
    FfpCapture capture;
    assert_true(ffp_capture_read(&capture, scratch, NULL));
    const FfpCamera *camera = &capture.views[1].camera;
    FfpRng rng = ffp_rng(3, 0);
    for (int k = 0; k < 100; k++) {
        const real u = ffp_rng_range(&rng, -5, 20), v = ffp_rng_range(&rng, -5, 20),
                   t = ffp_rng_range(&rng, 0.5F, 4);
        real direction[3], point[3], x, y;
        const real forward = ffp_pixel_ray(camera, u, v, direction);
        assert_near(ffp_dot3(direction, direction), 1, 1e-6);
        for (int i = 0; i < 3; i++) point[i] = camera->pose[4 * i + 3] + t * direction[i];
        const real z = ffp_project(camera, point, &x, &y);
        assert_near(z, t * forward, 1e-5);
        assert_near(x, u, 1e-3);
        assert_near(y, v, 1e-3);
    }
    ffp_capture_free(&capture);
}

// The sample that comes with the sources: its depth must put the object where the axes meet, inside its
// radius.
static void sample_is_consistent(void **state) {
    (void)state;
    FfpCapture capture, targets;
    FfpError err = {0};
    if (!ffp_capture_read(&capture, FFP_SOURCE_DIR "/data/sample", &err)) fail_msg("%s", err.text);
    if (!ffp_capture_read_targets(&targets, FFP_SOURCE_DIR "/data/sample/targets.json", &capture, &err)) {
        fail_msg("%s", err.text);
    }
    assert_true(capture.n_views == 8 && capture.n_patterns == 8 && targets.n_views == 6 &&
                targets.n_patterns == 8);
    assert_int_equal(ffp_capture_active_pattern(&capture, NULL, &err),
                     ffp_capture_find_pattern(&capture, "lollipop_0"));
    for (int i = 0; i < 3; i++) assert_near(capture.centre[i], 0, 1e-4);
    assert_true(capture.radius > 0.85F && capture.radius < 1.05F);
    for (int v = 0; v < 14; v++) {
        const FfpView *view = v < 8 ? &capture.views[v] : &targets.views[v - 8];
        int surface = 0, inside = 0;
        for (int i = 0; i < 128 * 128; i++) {
            real direction[3], square = 0;
            if (view->depth.data[i] == 0) continue;
            const real z =
                ffp_pixel_ray(&view->camera, (real)(i % 128) + 0.5F, (real)(i / 128) + 0.5F, direction);
            for (int k = 0; k < 3; k++) {
                const real p = view->camera.pose[4 * k + 3] + view->depth.data[i] / z * direction[k];
                square += p * p;
            }
            surface++;
            inside += square < capture.radius * capture.radius && view->coverage.data[i] > 0;
        }
        assert_true(surface > 1000 && inside >= surface - surface / 100);
    }
    ffp_capture_free(&targets);
    ffp_capture_free(&capture);
}

// The second sample has everything that it promises.
static void sculpture_is_consistent(void **state) {
    (void)state;
    FfpCapture capture, targets;
    FfpError err = {0};
    if (!ffp_capture_read(&capture, FFP_SOURCE_DIR "/data/sculpture", &err)) fail_msg("%s", err.text);
    if (!ffp_capture_read_targets(&targets, FFP_SOURCE_DIR "/data/sculpture/targets/scene.json", &capture,
                                  &err))
        fail_msg("%s", err.text);
    assert_true(capture.n_views == 8 && capture.n_patterns == 4 && targets.n_views == 6);
    assert_int_equal(ffp_capture_active_pattern(&capture, NULL, &err),
                     ffp_capture_find_pattern(&capture, "lollipop_0"));
    assert_true(capture.patterns[ffp_capture_find_pattern(&capture, "lollipop_3")].novel);
    for (int v = 0; v < 8; v++) {
        const FfpView *view = &capture.views[v];
        const FfpImage *white = &view->images[capture.white];
        int surface = 0, clipped = 0;
        assert_true(view->depth.data && white->width == 256 && white->height == 256);
        for (int i = 0; i < 256 * 256; i++) {
            if (!(view->depth.data[i] > 0)) continue;
            surface++;
            clipped += white->data[3 * i] > 0.999F;
        }
        assert_true(surface > 8000 && clipped < surface / 20);
    }
    ffp_capture_free(&targets);
    ffp_capture_free(&capture);
}

static void names_that_would_leave_the_folder_are_refused(void **state) {
    (void)state;
    static const char *const bad[] = {"", "..", "../up", "/root", ".hidden", "a/b"};
    char path[64];
    FfpError err;
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_false(ffp_picture_path(path, sizeof path, "out", bad[i], "white.png", &err));
    assert_false(ffp_picture_path(path, sizeof path, "out", "view", "../../white.png", &err));
    assert_false(ffp_picture_path(path, 16, "out", "view", "white.png", &err));
    assert_true(ffp_picture_path(path, sizeof path, "out", "view", "white.png", &err));
    assert_string_equal(path, "out/view_white.png");
}

static void photographs_come_from_their_files_when_asked_for(void **state) {
    (void)state;
    FfpError err;
    FfpCapture whole;
    if (!ffp_capture_read(&whole, in_scratch("scene.json"), &err)) fail_msg("%s", err.text);
    FfpCapture *left = ffp_capture_load_devices(in_scratch("scene.json"), true, &err);
    if (!left) fail_msg("%s", err.text);
    assert_null(left->views[0].coverage.data);
    assert_non_null(left->files);
    const int patterns[3] = {whole.black, whole.white, ffp_capture_find_pattern(&whole, "dots")};
    for (int v = 0; v < 2; v++)
        for (int size = 1; size <= 2; size++) {
            FfpView want =
                ffp_view_reduced(&whole.views[v], whole.n_patterns, patterns, 3, 12 / size, 10 / size);
            FfpView got;
            if (!ffp_photographs_read(&got, left, v, patterns, 3, 12 / size, 10 / size, &err))
                fail_msg("%s", err.text);
            assert_same_image(&got.coverage, &want.coverage, 0);
            for (int k = 0; k < 3; k++)
                assert_same_image(&got.images[patterns[k]], &want.images[patterns[k]], 0);
            assert_float_equal(got.camera.fx, want.camera.fx, 0);
            ffp_view_reduced_free(&want, whole.n_patterns);
            ffp_view_reduced_free(&got, left->n_patterns);
        }
    assert_true(ffp_photographs_has(left, 0, ffp_capture_find_pattern(left, "earth")));
    assert_false(ffp_photographs_has(left, 1, ffp_capture_find_pattern(left, "earth")));
    ffp_capture_free(left);
    ffp_free(left);
    ffp_capture_free(&whole);
}

static void a_missing_photograph_is_told_when_it_is_read(void **state) {
    (void)state;
    FfpError err;
    FfpView got;
    char there[1024], away[1024];
    snprintf(there, sizeof there, "%s", in_scratch("b1.png"));
    snprintf(away, sizeof away, "%s", in_scratch("away.png"));
    assert_int_equal(rename(there, away), 0);
    FfpCapture *left = ffp_capture_load_devices(in_scratch("scene.json"), false, &err);
    if (!left) fail_msg("%s", err.text);
    const int white = left->white;
    assert_true(ffp_photographs_read(&got, left, 0, &white, 1, 12, 10, &err));
    ffp_view_reduced_free(&got, left->n_patterns);
    for (int size = 1; size <= 2; size++) {
        assert_false(ffp_photographs_read(&got, left, 1, &white, 1, 12 / size, 10 / size, &err));
        assert_non_null(strstr(err.text, "b1.png"));
    }
    ffp_capture_free(left);
    ffp_free(left);
    assert_int_equal(rename(away, there), 0);
}

// The pictures that a reconstruction looks at, and those held out by which it is judged, are as reading the
// whole capture gives them; the others are not read.
static void what_is_not_wanted_is_not_read(void **state) {
    (void)state;
    FfpError err;
    const char *const named[1] = {"earth"};
    for (int n = 0; n < 2; n++) { // where none is named "dots", and "earth", which is held out
        FfpCapture whole, *part = ffp_capture_load_wanted(in_scratch("scene.json"), named, n, &err);
        if (!part || !ffp_capture_read(&whole, in_scratch("scene.json"), &err)) fail_msg("%s", err.text);
        const int left_out = n ? ffp_capture_find_pattern(&whole, "dots") : -1;
        for (int v = 0; v < 2; v++) {
            assert_same_image(&part->views[v].coverage, &whole.views[v].coverage, 0);
            if (n) assert_null(part->views[v].images[left_out].data);
            if (n) assert_non_null(whole.views[0].images[left_out].data);
            for (int p = 0; p < whole.n_patterns; p++) {
                const FfpImage *image = &whole.views[v].images[p];
                if (p != left_out && image->data) assert_same_image(&part->views[v].images[p], image, 0);
                assert_non_null(part->patterns[whole.white].image.data);
            }
        }
        ffp_capture_free(part);
        ffp_free(part);
        ffp_capture_free(&whole);
    }
    assert_null(ffp_capture_load_wanted(in_scratch("nothing.json"), NULL, 0, &err));
    assert_non_null(strstr(err.text, "nothing.json"));
    // Without bounds all photographs are looked at for them.
    FfpCapture *poses = ffp_capture_load_wanted(FFP_SOURCE_DIR "/data/sample", NULL, 0, &err);
    if (!poses) fail_msg("%s", err.text);
    for (int p = 0; p < poses->n_patterns; p++) assert_non_null(poses->views[0].images[p].data);
    ffp_capture_free(poses);
    ffp_free(poses);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(scene_is_read),
        cmocka_unit_test(scene_with_a_byte_order_mark_is_read),
        cmocka_unit_test(active_pattern_is_found),
        cmocka_unit_test(whole_scenes_are_written_and_read_back),
        cmocka_unit_test(names_are_listed_as_far_as_they_fit),
        cmocka_unit_test(names_that_would_leave_the_folder_are_refused),
        cmocka_unit_test(render_poses_are_read),
        cmocka_unit_test(unknown_intensity_is_estimated),
        cmocka_unit_test(coverage_has_other_sources),
        cmocka_unit_test(written_capture_comes_back),
        cmocka_unit_test(targets_share_patterns),
        cmocka_unit_test(normalising_keeps_the_light),
        cmocka_unit_test(bounds_meet_the_axes),
        cmocka_unit_test(pixels_and_points_agree),
        cmocka_unit_test(sample_is_consistent),
        cmocka_unit_test(sculpture_is_consistent),
        cmocka_unit_test(photographs_come_from_their_files_when_asked_for),
        cmocka_unit_test(a_missing_photograph_is_told_when_it_is_read),
        cmocka_unit_test(what_is_not_wanted_is_not_read),
    };
    return cmocka_run_group_tests(tests, make_capture_files, scratch_teardown);
}
