// The library without files: a capture from pixels, Gaussians from arrays, pictures into memory. Each must be
// to the bit what the same thing through files is. Only the public header is used for the library's part.
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/image/image.h"
#include "ffprocams.h"
#include "scratch.h"
#include "support.h"

#define SAMPLE FFP_SOURCE_DIR "/data/sample"
#define VIEWS_MAX 16
#define PATTERNS_MAX 16

typedef struct Rebuilt { // the sample's data as a caller would hold it
    FfpPatternData patterns[PATTERNS_MAX];
    FfpViewData views[VIEWS_MAX];
    FfpPicture photographs[VIEWS_MAX][PATTERNS_MAX];
    FfpCaptureData data;
    float *owned[VIEWS_MAX * PATTERNS_MAX];
    int n_owned;
} Rebuilt;

// RGB and coverage in one picture, as an EXR has them.
static FfpPicture with_alpha(Rebuilt *r, FfpPicture rgb, FfpPicture alpha) {
    if (!rgb.data) return rgb;
    const size_t pixels = (size_t)rgb.width * (size_t)rgb.height;
    float *rgba = ffp_alloc(pixels * 4 * sizeof *rgba, 1);
    assert_non_null(rgba);
    for (size_t i = 0; i < pixels; i++) {
        memcpy(rgba + 4 * i, (const float *)rgb.data + 3 * i, 3 * sizeof *rgba);
        rgba[4 * i + 3] = ((const float *)alpha.data)[i];
    }
    r->owned[r->n_owned++] = rgba;
    rgb.data = rgba, rgb.channels = 4;
    return rgb;
}

static void rebuild(Rebuilt *r, const FfpCapture *from) {
    const int n_views = ffp_capture_views(from), n_patterns = ffp_capture_patterns(from);
    *r = (Rebuilt){0};
    assert_true(n_views <= VIEWS_MAX && n_patterns <= PATTERNS_MAX);
    r->data = (FfpCaptureData){.name = "sample",
                               .n_patterns = n_patterns,
                               .n_views = n_views,
                               .patterns = r->patterns,
                               .views = r->views,
                               .black = -1,
                               .white = -1};
    for (int p = 0; p < n_patterns; p++) {
        const char *name = ffp_capture_pattern_name(from, p);
        r->patterns[p] = (FfpPatternData){.name = name, .picture = ffp_capture_picture(from, -1, p)};
        if (strcmp(name, "all_black") == 0) r->data.black = p;
        if (strcmp(name, "all_white") == 0) r->data.white = p;
    }
    for (int v = 0; v < n_views; v++) {
        FfpViewData *view = &r->views[v];
        view->id = ffp_capture_view_id(from, v);
        view->photographs = r->photographs[v];
        assert_true(ffp_capture_view_devices(from, v, &view->camera, &view->projector));
        view->masked = v % 2; // both ways to say what the object's share is
        if (view->masked) view->mask = ffp_capture_coverage(from, v);
        for (int p = 0; p < n_patterns; p++) {
            r->photographs[v][p] = ffp_capture_picture(from, v, p);
            if (!view->masked)
                r->photographs[v][p] = with_alpha(r, r->photographs[v][p], ffp_capture_coverage(from, v));
        }
    }
    ffp_capture_intensity(from, r->data.intensity);
    ffp_capture_bounds(from, r->data.centre, &r->data.radius);
}

static void free_rebuilt(Rebuilt *r) {
    for (int i = 0; i < r->n_owned; i++) ffp_free(r->owned[i]);
}

static const char *const lollipops[] = {"lollipop_0", "lollipop_2"};

static FfpGaussians *start_of_several(const FfpCapture *capture, int n) {
    FfpError err = {0};
    FfpReconstructionStats stats;
    const FfpReconstruction options = {
        .size = sizeof options, .patterns = lollipops, .n_patterns = n, .polish = 2};
    FfpGaussians *gaussians = ffp_reconstruct(NULL, capture, &options, &stats, &err);
    if (!gaussians) fail_msg("%s", err.text);
    assert_string_equal(stats.pattern, "lollipop_0");
    assert_int_equal(stats.patterns, n > 0 ? n : 1);
    return gaussians;
}

static FfpGaussians *start_of(const FfpCapture *capture) {
    return start_of_several(capture, 1);
}

static void assert_same(FfpGaussians *a, FfpGaussians *b) {
    const FfpGaussianArrays x = ffp_gaussians_arrays(a), y = ffp_gaussians_arrays(b);
    const size_t n = (size_t)x.count;
    assert_int_equal(x.count, y.count);
    assert_memory_equal(x.centre, y.centre, 3 * n * sizeof(float));
    assert_memory_equal(x.scale, y.scale, 3 * n * sizeof(float));
    assert_memory_equal(x.rotation, y.rotation, 4 * n * sizeof(float));
    assert_memory_equal(x.opacity, y.opacity, n * sizeof(float));
    assert_memory_equal(x.albedo, y.albedo, 3 * n * sizeof(float));
    assert_memory_equal(x.roughness, y.roughness, n * sizeof(float));
    assert_memory_equal(x.ambient, y.ambient, 3 * n * sizeof(float));
}

static void test_memory_and_files_give_the_same_gaussians(void **state) {
    (void)state;
    FfpError err = {0};
    FfpCapture *files = ffp_capture_open(NULL, SAMPLE, NULL, &err);
    assert_non_null(files);
    Rebuilt r;
    rebuild(&r, files);
    FfpCapture *memory = ffp_capture_from_memory(NULL, &r.data, &err);
    if (!memory) fail_msg("%s", err.text);
    free_rebuilt(&r); // nothing of it may be needed any more
    FfpGaussians *a = start_of(files), *b = start_of(memory);
    assert_same(a, b);
    const FfpGaussianArrays arrays = ffp_gaussians_arrays(a);
    FfpGaussians *copy = ffp_gaussians_from_arrays(NULL, &arrays, &err);
    if (!copy) fail_msg("%s", err.text);
    assert_same(a, copy);
    ffp_gaussians_close(copy), ffp_gaussians_close(b);
    b = start_of_several(files, 0); // the first pattern, whether it is named or not
    assert_same(a, b);
    ffp_gaussians_close(a), ffp_gaussians_close(b);
    a = start_of_several(files, 2), b = start_of_several(memory, 2);
    assert_same(a, b);
    ffp_gaussians_close(a), ffp_gaussians_close(b);
    ffp_capture_close(memory), ffp_capture_close(files);
}

static void expect_no_gaussians(const FfpCapture *capture, const char *const *names, int n,
                                const char *word) {
    FfpError err = {0};
    const FfpReconstruction options = {.size = sizeof options, .patterns = names, .n_patterns = n};
    assert_null(ffp_reconstruct(NULL, capture, &options, NULL, &err));
    if (!strstr(err.text, word)) fail_msg("no \"%s\" in: %s", word, err.text);
}

// A second pattern that some views were photographed under counts there; what cannot be meant is refused.
static void test_patterns_that_are_not_everywhere(void **state) {
    (void)state;
    FfpError err = {0};
    FfpCapture *files = ffp_capture_open(NULL, SAMPLE, NULL, &err);
    assert_non_null(files);
    Rebuilt r;
    rebuild(&r, files);
    int second = 0, third = 0;
    for (int p = 0; p < r.data.n_patterns; p++) {
        if (strcmp(r.patterns[p].name, "lollipop_2") == 0) second = p;
        if (strcmp(r.patterns[p].name, "lollipop_3") == 0) third = p;
    }
    for (int v = 0; v < r.data.n_views; v++) {
        if (v > 0) r.photographs[v][second].data = NULL;
        r.photographs[v][third].data = NULL;
    }
    FfpCapture *memory = ffp_capture_from_memory(NULL, &r.data, &err);
    if (!memory) fail_msg("%s", err.text);
    FfpGaussians *one = start_of(memory), *two = start_of_several(memory, 2);
    FfpGaussians *everywhere = start_of_several(files, 2);
    const FfpGaussianArrays x = ffp_gaussians_arrays(one), y = ffp_gaussians_arrays(two),
                            z = ffp_gaussians_arrays(everywhere);
    assert_true(x.count != y.count || memcmp(x.centre, y.centre, 3 * (size_t)x.count * sizeof(float)) != 0);
    assert_true(z.count != y.count || memcmp(z.centre, y.centre, 3 * (size_t)z.count * sizeof(float)) != 0);
    ffp_gaussians_close(one), ffp_gaussians_close(two), ffp_gaussians_close(everywhere);

    static const char *const
        turned[] = {"lollipop_2", "lollipop_0"},
        *const nowhere[] = {"lollipop_0", "lollipop_3"},
        *const twice[] = {"lollipop_0", "lollipop_1", "lollipop_0"}, *const absent[] = {"lollipop_0", "pear"},
        *const plain[] = {"lollipop_0", "all_white"}, *const nameless[] = {"lollipop_0", NULL};
    expect_no_gaussians(memory, turned, 2, "has no picture under pattern 'lollipop_2'");
    expect_no_gaussians(memory, nowhere, 2, "no view has a picture under pattern 'lollipop_3'");
    expect_no_gaussians(memory, twice, 3, "'lollipop_0' is named twice");
    expect_no_gaussians(memory, absent, 2, "no pattern 'pear'");
    expect_no_gaussians(memory, plain, 2, "'all_white' is uniform");
    expect_no_gaussians(memory, nameless, 2, "is required, but is NULL (patterns[1])");
    expect_no_gaussians(memory, NULL, 2, "is required, but is NULL (patterns)");
    free_rebuilt(&r);
    ffp_capture_close(memory), ffp_capture_close(files);
}

// 8-bit pixels as a PNG holds them, with rows that lie apart, against the file.
static void test_bytes_are_read_as_a_png_is(void **state) {
    (void)state;
    enum { WIDTH = 24, HEIGHT = 16, ROW = 4 * WIDTH + 12 };
    FfpError err = {0};
    unsigned char rows[HEIGHT * ROW], pattern[16 * 16 * 3];
    FfpImage image = ffp_image_new(WIDTH, HEIGHT, 4), rgb, alpha;
    for (int i = 0; i < (int)sizeof pattern; i++) pattern[i] = (unsigned char)(37 * i);
    for (int y = 0; y < HEIGHT; y++)
        for (int i = 0; i < 4 * WIDTH; i++) {
            rows[y * ROW + i] = (unsigned char)(i % 4 == 3 ? (y * 255) / HEIGHT : 11 * i + 5 * y);
            image.data[y * 4 * WIDTH + i] = (real)rows[y * ROW + i] / 255;
        }
    const char *path = in_scratch("bytes.png");
    assert_true(ffp_image_write_png(&image, path, &err));
    assert_true(ffp_image_read_over_black(&rgb, &alpha, path, &err));
    const FfpPicture bytes = {.data = rows,
                              .width = WIDTH,
                              .height = HEIGHT,
                              .channels = 4,
                              .type = FFP_PIXELS_U8,
                              .row_bytes = ROW};
    const FfpPicture photographs[3] = {bytes, bytes, bytes};
    const FfpPinhole device = {.width = WIDTH,
                               .height = HEIGHT,
                               .fx = 30,
                               .fy = 30,
                               .cx = 12,
                               .cy = 8,
                               .pose = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, -4, 0, 0, 0, 1}};
    FfpPinhole projector = device;
    projector.width = projector.height = 16;
    const FfpPatternData patterns[3] = {
        {.name = "black"},
        {.name = "white"},
        {.name = "dots",
         .picture = {.data = pattern, .width = 16, .height = 16, .channels = 3, .type = FFP_PIXELS_U8}}};
    const FfpViewData view = {
        .id = "a", .camera = device, .projector = projector, .photographs = photographs};
    const FfpCaptureData data = {.name = "tiny",
                                 .n_patterns = 3,
                                 .n_views = 1,
                                 .patterns = patterns,
                                 .views = &view,
                                 .black = 0,
                                 .white = 1,
                                 .intensity = {1, 1, 1},
                                 .centre = {0, 0, 0},
                                 .radius = 1};
    FfpCapture *capture = ffp_capture_from_memory(NULL, &data, &err);
    if (!capture) fail_msg("%s", err.text);
    const FfpPicture got = ffp_capture_picture(capture, 0, 2), share = ffp_capture_coverage(capture, 0);
    assert_memory_equal(got.data, rgb.data, sizeof(float) * 3 * WIDTH * HEIGHT);
    assert_memory_equal(share.data, alpha.data, sizeof(float) * WIDTH * HEIGHT);
    ffp_capture_close(capture);
    ffp_image_free(&image), ffp_image_free(&rgb), ffp_image_free(&alpha);
}

static void test_drawing_into_memory_is_what_files_hold(void **state) {
    (void)state;
    FfpError err = {0};
    FfpCapture *capture = ffp_capture_open(NULL, SAMPLE, NULL, &err);
    assert_non_null(capture);
    FfpGaussians *gaussians = start_of(capture);
    const char *view = ffp_capture_view_id(capture, 1), *pattern = "lollipop_0";
    const FfpPictures options = {.size = sizeof options,
                                 .views = &view,
                                 .n_views = 1,
                                 .patterns = &pattern,
                                 .n_patterns = 1,
                                 .folder = in_scratch("drawn")};
    if (ffp_render_pictures(NULL, gaussians, capture, &options, &err) != 1) fail_msg("%s", err.text);
    char path[512];
    snprintf(path, sizeof path, "drawn/%s_%s.png", view, pattern);
    FfpImage file;
    assert_true(ffp_image_read(&file, in_scratch(path), FFP_COLOUR_ENCODED, &err));

    FfpPinhole camera, projector;
    double intensity[3];
    assert_true(ffp_capture_view_devices(capture, 1, &camera, &projector));
    ffp_capture_intensity(capture, intensity);
    FfpPicture light = {0};
    for (int p = 0; p < ffp_capture_patterns(capture); p++)
        if (strcmp(ffp_capture_pattern_name(capture, p), pattern) == 0)
            light = ffp_capture_picture(capture, -1, p);
    FfpRenderer *renderer = ffp_renderer_new(NULL, (FfpDrawing){0}, &err);
    const size_t pixels = (size_t)camera.width * (size_t)camera.height;
    unsigned char *bytes = ffp_alloc(3 * pixels, 1);
    float *values = ffp_alloc(3 * pixels * sizeof *values, 1);
    assert_true(bytes && values);
    assert_false(ffp_renderer_shade(NULL, renderer, &light, intensity, bytes, 3 * pixels, FFP_PIXELS_U8, 0,
                                    &err)); // not aimed
    assert_int_equal(err.code, FFP_ERROR_ARGUMENT);
    assert_true(ffp_renderer_aim(NULL, renderer, gaussians, &camera, &projector, &err));
    assert_true(
        ffp_renderer_shade(NULL, renderer, &light, intensity, bytes, 3 * pixels, FFP_PIXELS_U8, 0, &err));
    for (size_t i = 0; i < pixels; i++)
        for (size_t c = 0; c < 3; c++)
            assert_int_equal(bytes[3 * i + c], (int)(file.data[4 * i + c] * 255 + 0.5F));
    // Dark, the object shows its ambient colour and no more.
    assert_true(ffp_renderer_shade(NULL, renderer, NULL, intensity, values, 3 * pixels * sizeof *values,
                                   FFP_PIXELS_F32, 0, &err));
    double dark = 0, lit = 0;
    for (size_t i = 0; i < 3 * pixels; i++) dark += (double)values[i], lit += bytes[i] / 255.0;
    assert_true(dark > 0 && dark < 0.9 * lit);
    for (int m = 0; m < FFP_MAP_COUNT; m++) {
        double sum = 0;
        assert_true(ffp_renderer_map(NULL, renderer, (FfpMap)m, values, 3 * pixels, &err));
        for (size_t i = 0; i < pixels * (size_t)ffp_map_channels((FfpMap)m); i++)
            sum += fabs((double)values[i]);
        assert_true(sum > 0 && isfinite(sum));
    }
    // No more is written than there is room for.
    assert_false(
        ffp_renderer_shade(NULL, renderer, &light, intensity, bytes, 3 * pixels - 1, FFP_PIXELS_U8, 0, &err));
    assert_non_null(strstr(err.text, "(size)"));
    assert_false(ffp_renderer_shade(NULL, renderer, &light, intensity, bytes, 3 * pixels, FFP_PIXELS_U8,
                                    3 * (size_t)camera.width + 1, &err));
    assert_false(ffp_renderer_map(NULL, renderer, FFP_MAP_NORMAL, values, 3 * pixels - 1, &err));
    assert_non_null(strstr(err.text, "(count)"));
    light.width--;
    assert_false(
        ffp_renderer_shade(NULL, renderer, &light, intensity, bytes, 3 * pixels, FFP_PIXELS_U8, 0, &err));
    ffp_renderer_close(renderer);
    ffp_image_free(&file);
    ffp_free(bytes), ffp_free(values);
    ffp_gaussians_close(gaussians), ffp_capture_close(capture);
}

// A picture too large to be drawn at once is the same as one that is: files draw it in strips, a renderer
// whole.
static void test_large_files_are_drawn_in_strips(void **state) {
    (void)state;
    enum { SIDE = 1600 };
    FfpError err = {0};
    FfpCapture *capture = ffp_capture_open(NULL, SAMPLE, NULL, &err);
    assert_non_null(capture);
    FfpGaussians *gaussians = start_of(capture);
    const char *view = ffp_capture_view_id(capture, 0);
    const FfpPictures options = {
        .size = sizeof options, .views = &view, .n_views = 1, .width = SIDE, .folder = in_scratch("large")};
    if (ffp_render_pictures(NULL, gaussians, capture, &options, &err) != 1) fail_msg("%s", err.text);

    FfpPinhole camera, projector;
    double intensity[3];
    assert_true(ffp_capture_view_devices(capture, 0, &camera, &projector));
    ffp_capture_intensity(capture, intensity);
    const double scale = (double)SIDE / camera.width;
    camera.width = camera.height = SIDE;
    double *const lengths[] = {&camera.fx, &camera.fy, &camera.cx, &camera.cy};
    for (int i = 0; i < 4; i++) *lengths[i] *= scale;
    int white = 0;
    while (ffp_capture_pattern_role(capture, white) != FFP_PATTERN_WHITE) white++;
    const FfpPicture light = ffp_capture_picture(capture, -1, white);
    char path[512];
    snprintf(path, sizeof path, "large/%s_%s.png", view, ffp_capture_pattern_name(capture, white));
    FfpImage file;
    assert_true(ffp_image_read(&file, in_scratch(path), FFP_COLOUR_ENCODED, &err));
    assert_int_equal(file.height, SIDE);
    FfpRenderer *renderer = ffp_renderer_new(NULL, (FfpDrawing){0}, &err);
    unsigned char *bytes = ffp_alloc((size_t)3 * SIDE * SIDE, 1);
    assert_true(ffp_renderer_aim(NULL, renderer, gaussians, &camera, &projector, &err));
    assert_true(ffp_renderer_shade(NULL, renderer, &light, intensity, bytes, (size_t)3 * SIDE * SIDE,
                                   FFP_PIXELS_U8, 0, &err));
    int64_t lit = 0, different = 0;
    for (size_t i = 0; i < (size_t)SIDE * SIDE; i++)
        for (size_t c = 0; c < 3; c++) {
            const int there = (int)(file.data[4 * i + c] * 255 + 0.5F), here = bytes[3 * i + c];
            assert_true(abs(there - here) <= 2); // a strip's principal point is rounded otherwise
            different += there != here;
            lit += here > 0;
        }
    assert_true(lit > SIDE && different < lit / 100);
    ffp_renderer_close(renderer);
    ffp_image_free(&file);
    ffp_free(bytes);
    ffp_gaussians_close(gaussians);
    ffp_capture_close(capture);
}

static void refuse(Rebuilt *r, const char *text) {
    FfpError err = {0};
    assert_null(ffp_capture_from_memory(NULL, &r->data, &err));
    if (!strstr(err.text, text)) fail_msg("'%s' does not name '%s'", err.text, text);
}

static void test_wrong_data_is_refused_by_name(void **state) {
    (void)state;
    FfpError err = {0};
    FfpCapture *files = ffp_capture_open(NULL, SAMPLE, NULL, &err);
    assert_non_null(files);
    Rebuilt whole, r;
    rebuild(&whole, files);
#define WRONG(change, text)                                                                                  \
    do {                                                                                                     \
        r = whole;                                                                                           \
        r.data.patterns = r.patterns, r.data.views = r.views;                                                \
        change;                                                                                              \
        refuse(&r, text);                                                                                    \
    } while (0)
    WRONG(r.views[2].camera.fx = NAN, "camera");
    WRONG(r.views[2].camera.pose[0] += 0.5, "not rigid");
    WRONG(r.views[2].projector.pose[3] = INFINITY, "pose");
    WRONG(r.views[1].id = r.views[0].id, "duplicate");
    WRONG(r.views[1].id = "../a", "invalid name");
    WRONG(r.data.black = r.data.white, "patterns");
    WRONG(r.data.n_views = 0, "views");
    WRONG(r.data.radius = -1, "radius");
    WRONG(r.data.intensity[1] = NAN, "intensity");
    WRONG(r.views[0].camera.width = 1 << 20, "size");
    FfpPicture other[PATTERNS_MAX];
    memcpy(other, whole.photographs[0], sizeof other);
    other[whole.data.white].width--;
    WRONG(r.views[0].photographs = other, "photograph under all_white");
    memcpy(other, whole.photographs[0], sizeof other);
    other[whole.data.white].data = NULL;
    WRONG(r.views[0].photographs = other, "all_white");
    memcpy(other, whole.photographs[0], sizeof other);
    other[0].row_bytes = 5;
    WRONG(r.views[0].photographs = other, "rows of 5 bytes");
    // Positions in the projector: floats, three channels, of the camera's size, near the projector's picture.
    static float map[8 * 8 * 3] = {1e5F, 0, 1};
    const FfpPicture wrong = {.data = map, .width = 8, .height = 8, .channels = 3, .type = FFP_PIXELS_F32};
    WRONG(r.views[0].correspondence = wrong, "correspondence");
    WRONG(r.views[0].correspondence = wrong; r.views[0].correspondence.channels = 1, "three channels");
    WRONG(r.views[0].correspondence = wrong;
          r.views[0].correspondence.type = FFP_PIXELS_U8, "three channels");
    free_rebuilt(&whole);
    ffp_capture_close(files);

    float three[3] = {0, 0, 0}, four[4] = {1, 0, 0, 0}, scale[3] = {1, 1, 1}, one[1] = {0.5F};
    FfpGaussianArrays arrays = {.count = 1,
                                .centre = three,
                                .scale = scale,
                                .rotation = four,
                                .opacity = one,
                                .albedo = three,
                                .roughness = one,
                                .ambient = three,
                                .scattered = three};
    FfpGaussians *gaussians = ffp_gaussians_from_arrays(NULL, &arrays, &err);
    assert_non_null(gaussians);
    ffp_gaussians_close(gaussians);
    scale[1] = 0;
    assert_null(ffp_gaussians_from_arrays(NULL, &arrays, &err));
    assert_non_null(strstr(err.text, "scale"));
    scale[1] = NAN;
    assert_null(ffp_gaussians_from_arrays(NULL, &arrays, &err));
    scale[1] = 1, four[0] = 0;
    assert_null(ffp_gaussians_from_arrays(NULL, &arrays, &err));
    arrays.count = 0;
    assert_null(ffp_gaussians_from_arrays(NULL, &arrays, &err));
}

static void test_patterns_have_their_roles(void **state) {
    (void)state;
    FfpError err = {0};
    Rebuilt r;
    FfpCapture *from = ffp_capture_open(NULL, SAMPLE, NULL, &err);
    assert_non_null(from);
    rebuild(&r, from);
    const int held_out = r.data.n_patterns - 1;
    r.patterns[held_out].held_out = true;
    FfpCapture *capture = ffp_capture_from_memory(NULL, &r.data, &err);
    if (!capture) fail_msg("%s", err.text);
    for (int p = 0; p < r.data.n_patterns; p++) {
        FfpPatternRole role = FFP_PATTERN_ACTIVE;
        if (p == r.data.black) role = FFP_PATTERN_BLACK;
        if (p == r.data.white) role = FFP_PATTERN_WHITE;
        assert_int_equal(ffp_capture_pattern_role(from, p), role); // the sample holds nothing back
        if (p == held_out) role = FFP_PATTERN_HELD_OUT;
        assert_int_equal(ffp_capture_pattern_role(capture, p), role);
    }
    assert_int_equal(ffp_capture_pattern_role(capture, -1), FFP_PATTERN_ACTIVE);
    assert_int_equal(ffp_capture_pattern_role(capture, r.data.n_patterns), FFP_PATTERN_ACTIVE);
    ffp_capture_close(capture);
    ffp_capture_close(from);
    free_rebuilt(&r);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_memory_and_files_give_the_same_gaussians),
        cmocka_unit_test(test_patterns_that_are_not_everywhere),
        cmocka_unit_test(test_bytes_are_read_as_a_png_is),
        cmocka_unit_test(test_drawing_into_memory_is_what_files_hold),
        cmocka_unit_test(test_wrong_data_is_refused_by_name),
        cmocka_unit_test(test_patterns_have_their_roles),
        cmocka_unit_test(test_large_files_are_drawn_in_strips),
    };
    return cmocka_run_group_tests(tests, scratch_setup, scratch_teardown);
}
