// Labels: threads
// Drawing several views with gradients through the public header: the same pictures and maps as one by one,
// gradients against differences of the loss along a direction, the same bits for any number of threads, and
// what is refused.
#include <math.h>
#include "core/base/rng.h"
#include "initialised.h"
#include "support.h"

enum {
    PIXELS = SMALL_SIDE * SMALL_SIDE,
    VIEWS = SMALL_VIEWS,
    PATTERNS = 3, // black, and what the capture has
    PICTURES = VIEWS * PATTERNS * PIXELS * 3,
    PATTERN = SMALL_PATTERN * SMALL_PATTERN * 3
};

typedef struct Scene {
    FfpGaussianArrays arrays;
    FfpPinhole cameras[VIEWS], projectors[VIEWS];
    float patterns[PATTERNS][PATTERN];
    FfpPicture pictures[PATTERNS];
    FfpRenderBatch batch;
    float weights[PICTURES], map_weights[FFP_MAP_COUNT][VIEWS * PIXELS * 3];
    float drawn[PICTURES], maps[FFP_MAP_COUNT][VIEWS * PIXELS * 3];
    float *map_out[FFP_MAP_COUNT];
    const float *map_in[FFP_MAP_COUNT];
} Scene;

static Scene scene; // too large for a stack
static FfpError err;

static void require(bool ok) {
    if (!ok) fail_msg("%s", err.text);
}

static void fill(FfpRng *rng, float *to, int n) {
    for (int i = 0; i < n; i++) to[i] = 2 * (float)ffp_rng_uniform(rng) - 1;
}

static void make_scene(bool linear) {
    FfpRng rng = ffp_rng(3, 1);
    scene.arrays = ffp_gaussians_arrays(gaussians);
    for (int v = 0; v < VIEWS; v++)
        assert_true(ffp_capture_view_devices(capture, v, &scene.cameras[v], &scene.projectors[v]));
    for (int p = 1; p < PATTERNS; p++) {
        fill(&rng, scene.patterns[p], PATTERN);
        for (int i = 0; i < PATTERN; i++) scene.patterns[p][i] = 0.5F + 0.3F * scene.patterns[p][i];
        scene.pictures[p] = (FfpPicture){.data = scene.patterns[p],
                                         .width = SMALL_PATTERN,
                                         .height = SMALL_PATTERN,
                                         .channels = 3,
                                         .type = FFP_PIXELS_F32};
    }
    scene.batch = (FfpRenderBatch){.gaussians = scene.arrays,
                                   .n_views = VIEWS,
                                   .cameras = scene.cameras,
                                   .projectors = scene.projectors,
                                   .n_patterns = PATTERNS,
                                   .patterns = scene.pictures,
                                   .linear = linear,
                                   .gradients = true};
    ffp_capture_intensity(capture, scene.batch.intensity);
    fill(&rng, scene.weights, PICTURES);
    for (int m = 0; m < FFP_MAP_COUNT; m++) {
        fill(&rng, scene.map_weights[m], VIEWS * PIXELS * 3);
        scene.map_out[m] = scene.maps[m];
        scene.map_in[m] = scene.map_weights[m];
    }
}

// Of the pictures.
static size_t numbers(void) {
    return (size_t)scene.batch.n_views * (size_t)scene.batch.n_patterns * PIXELS * 3;
}

static void forward(FfpContext *context, FfpRenderer *renderer) {
    require(ffp_renderer_forward(context, renderer, &scene.batch, scene.drawn, numbers(), scene.map_out,
                                 FFP_MAP_COUNT, &err));
}

// --- The same as one by one. ---

static void compare_view(FfpRenderer *alone, int v) {
    float picture[PIXELS * 3];
    require(ffp_renderer_aim(NULL, alone, gaussians, &scene.cameras[v], &scene.projectors[v], &err));
    for (int p = 0; p < PATTERNS; p++) {
        require(ffp_renderer_shade(NULL, alone, &scene.pictures[p], scene.batch.intensity, picture,
                                   sizeof picture, FFP_PIXELS_F32, 0, &err));
        assert_memory_equal(picture, scene.drawn + (v * PATTERNS + p) * PIXELS * 3, sizeof picture);
    }
    for (int m = 0; m < FFP_MAP_COUNT; m++) {
        const size_t of_map = (size_t)PIXELS * (size_t)ffp_map_channels((FfpMap)m);
        require(ffp_renderer_map(NULL, alone, (FfpMap)m, picture, PIXELS * 3, &err));
        assert_memory_equal(picture, scene.maps[m] + (size_t)v * of_map, of_map * sizeof(float));
    }
}

static void test_as_one_by_one(void **state) {
    (void)state;
    make_scene(false);
    FfpRenderer *renderer = ffp_renderer_new(NULL, (FfpDrawing){0}, &err);
    for (int gradients = 0; gradients < 2; gradients++) {
        scene.batch.gradients = gradients;
        memset(scene.drawn, 0, sizeof scene.drawn);
        forward(NULL, renderer);
        for (int v = 0; v < VIEWS; v++) compare_view(renderer, v);
        scene.batch.same_patterns = true; // as the second round has them
        scene.batch.patterns = NULL;
    }
    ffp_renderer_close(renderer);
}

// --- Gradients. ---

typedef struct Gradients {
    float *all[7], *patterns; // of the Gaussians, in the arrays' order
    double intensity[3], cameras[6 * VIEWS], projectors[6 * VIEWS], camera_focals[2 * VIEWS],
        projector_focals[2 * VIEWS];
} Gradients;

static const int widths[7] = {3, 3, 4, 1, 3, 1, 3};

static FfpRenderGradients gradients_out(Gradients *g) {
    for (int a = 0; a < 7; a++) g->all[a] = calloc((size_t)(scene.arrays.count * widths[a]), sizeof(float));
    g->patterns = calloc((size_t)PATTERNS * PATTERN, sizeof(float));
    return (FfpRenderGradients){.gaussians = {.centre = g->all[0],
                                              .scale = g->all[1],
                                              .rotation = g->all[2],
                                              .opacity = g->all[3],
                                              .albedo = g->all[4],
                                              .roughness = g->all[5],
                                              .ambient = g->all[6]},
                                .patterns = g->patterns,
                                .intensity = g->intensity,
                                .cameras = g->cameras,
                                .projectors = g->projectors,
                                .camera_focals = g->camera_focals,
                                .projector_focals = g->projector_focals};
}

static void free_gradients(Gradients *g) {
    for (int a = 0; a < 7; a++) free(g->all[a]);
    free(g->patterns);
}

static Gradients backward(FfpContext *context, FfpRenderer *renderer) {
    Gradients g = {.patterns = NULL};
    const FfpRenderGradients out = gradients_out(&g);
    require(ffp_renderer_backward(context, renderer, scene.weights, numbers(), scene.map_in, FFP_MAP_COUNT,
                                  &out, &err));
    return g;
}

static double loss(FfpRenderer *renderer) {
    double sum = 0;
    forward(NULL, renderer);
    for (int i = 0; i < PICTURES; i++) sum += (double)scene.drawn[i] * (double)scene.weights[i];
    for (int m = 0; m < FFP_MAP_COUNT; m++)
        for (int i = 0; i < VIEWS * PIXELS * ffp_map_channels((FfpMap)m); i++)
            sum += (double)scene.maps[m][i] * (double)scene.map_weights[m][i];
    return sum;
}

// n numbers moved by `step` along the signs of their gradient, where the loss changes most.
static void check_direction(FfpRenderer *renderer, const char *what, float *numbers, const float *gradient,
                            int64_t n, double step) {
    float *kept = malloc((size_t)n * sizeof *kept);
    double slope = 0, ends[2];
    memcpy(kept, numbers, (size_t)n * sizeof *kept);
    for (int64_t i = 0; i < n; i++) slope += fabs((double)gradient[i]);
    for (int end = 0; end < 2; end++) {
        for (int64_t i = 0; i < n; i++) {
            const double sign = gradient[i] > 0 ? 1 : gradient[i] < 0 ? -1 : 0;
            numbers[i] = (float)((double)kept[i] + (end ? 1 : -1) * step * sign);
        }
        ends[end] = loss(renderer);
    }
    memcpy(numbers, kept, (size_t)n * sizeof *kept);
    free(kept);
    const double numeric = (ends[1] - ends[0]) / (2 * step);
    if (!(slope > 0 && fabs(numeric - slope) <= 0.03 * slope))
        fail_msg("%s: analytic %.6g, numeric %.6g", what, slope, numeric);
}

enum { OPACITY = 3, ALBEDO, ROUGHNESS, AMBIENT };

static float *array_of(int attribute) {
    float *arrays[7] = {scene.arrays.centre,  scene.arrays.scale,  scene.arrays.rotation,
                        scene.arrays.opacity, scene.arrays.albedo, scene.arrays.roughness,
                        scene.arrays.ambient};
    return arrays[attribute];
}

// Attributes that move no outline, so that differences in single precision say something.
static void check_gaussians(FfpRenderer *renderer, const Gradients *g) {
    static const double steps[7] = {[ALBEDO] = 1e-3, [ROUGHNESS] = 1e-3, [AMBIENT] = 1e-4};
    static const char *const names[7] = {
        [ALBEDO] = "albedo", [ROUGHNESS] = "roughness", [AMBIENT] = "ambient"};
    for (int a = ALBEDO; a <= AMBIENT; a++)
        check_direction(renderer, names[a], array_of(a), g->all[a], scene.arrays.count * widths[a], steps[a]);
}

static void check_numbers(FfpRenderer *renderer, const Gradients *g) {
    const double step = 1e-2 * scene.batch.intensity[0];
    for (int c = 0; c < 3; c++) {
        double *number = &scene.batch.intensity[c], kept = *number, ends[2];
        for (int end = 0; end < 2; end++) {
            *number = kept + (end ? step : -step);
            ends[end] = loss(renderer);
        }
        *number = kept;
        const double numeric = (ends[1] - ends[0]) / (2 * step);
        if (!(fabs(numeric - g->intensity[c]) <= 0.03 * fabs(numeric) + 1e-3))
            fail_msg("intensity %d: analytic %g, numeric %g", c, g->intensity[c], numeric);
    }
    check_direction(renderer, "patterns", scene.patterns[1], g->patterns + PATTERN, (PATTERNS - 1) * PATTERN,
                    5e-3);
    for (int i = 0; i < PATTERN; i++) assert_true(g->patterns[i] == 0); // the dark one's
}

// The view pass is held against differences in double (test_aim_f64); here, that the numbers arrive where
// they belong.
static void check_form(bool linear) {
    make_scene(linear);
    FfpRenderer *renderer = ffp_renderer_new(NULL, (FfpDrawing){.form = FFP_FORM_PAPER, .samples = 2}, &err);
    for (int a = ALBEDO; a <= AMBIENT; a++) // room for a step
        for (int64_t i = 0; i < scene.arrays.count * widths[a]; i++)
            array_of(a)[i] = fminf(fmaxf(array_of(a)[i], 0.01F), 0.9F);
    forward(NULL, renderer);
    Gradients g = backward(NULL, renderer);
    check_gaussians(renderer, &g);
    check_numbers(renderer, &g);
    free_gradients(&g);
    ffp_renderer_close(renderer);
}

static void test_linear_gradients(void **state) {
    (void)state;
    check_form(true);
}

static void test_encoded_gradients(void **state) {
    (void)state;
    check_form(false);
}

// Two splats behind each other in a camera's middle, where both have their full opacity a: their weights are
// a and (1 - a) a, and the distortion 2 a^2 (1 - a) |z_2 - z_1| (FF-ProCams, Eq. 22).
static void test_distortion(void **state) {
    (void)state;
    enum { SIDE = 33, MIDDLE = SIDE * SIDE / 2 };
    const float a = 0.5F, apart = 0.2F;
    float centre[6] = {0, 0, 3, 0, 0, 3 + apart}, scale[6] = {0.3F, 0.3F, 0.3F, 0.3F, 0.3F, 0.3F},
          rotation[8] = {1, 0, 0, 0, 1, 0, 0, 0}, opacity[2] = {a, a}, even[6] = {0.5F, 0.5F, 0.5F},
          map[SIDE * SIDE], grad[SIDE * SIDE] = {[MIDDLE] = 1}, moved[6];
    float *maps[FFP_MAP_COUNT] = {[FFP_MAP_DISTORTION] = map};
    const float *grads[FFP_MAP_COUNT] = {[FFP_MAP_DISTORTION] = grad};
    const FfpPinhole camera = {.width = SIDE,
                               .height = SIDE,
                               .fx = SIDE,
                               .fy = SIDE,
                               .cx = SIDE / 2.0,
                               .cy = SIDE / 2.0,
                               .pose = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}};
    const FfpRenderBatch batch = {.gaussians = {.count = 2,
                                                .centre = centre,
                                                .scale = scale,
                                                .rotation = rotation,
                                                .opacity = opacity,
                                                .albedo = even,
                                                .roughness = opacity,
                                                .ambient = even},
                                  .n_views = 1,
                                  .cameras = &camera,
                                  .projectors = &camera,
                                  .gradients = true};
    const FfpRenderGradients out = {.gaussians = {.centre = moved}};
    FfpRenderer *renderer = ffp_renderer_new(NULL, (FfpDrawing){.form = FFP_FORM_PAPER, .samples = 1}, &err);
    require(ffp_renderer_forward(NULL, renderer, &batch, NULL, 0, maps, FFP_MAP_COUNT, &err));
    assert_float_equal(map[MIDDLE], 2 * a * a * (1 - a) * apart, 1e-5);
    require(ffp_renderer_backward(NULL, renderer, NULL, 0, grads, FFP_MAP_COUNT, &out, &err));
    assert_float_equal(moved[2], -2 * a * a * (1 - a), 1e-4);
    assert_float_equal(moved[5], 2 * a * a * (1 - a), 1e-4);
    ffp_renderer_close(renderer);
}

// Of every view alone, and of all together: the same, added up.
static void test_views_add_up(void **state) {
    (void)state;
    make_scene(false);
    FfpRenderer *renderer = ffp_renderer_new(NULL, (FfpDrawing){0}, &err);
    forward(NULL, renderer);
    Gradients together = backward(NULL, renderer), again = backward(NULL, renderer);
    const size_t centres = (size_t)scene.arrays.count * 3;
    assert_memory_equal(together.all[0], again.all[0], centres * sizeof(float)); // a second time
    double *sum = calloc(centres, sizeof *sum), largest = 0, worst = 0;
    for (int v = 0; v < VIEWS; v++) {
        scene.batch.n_views = 1;
        scene.batch.cameras = scene.cameras + v, scene.batch.projectors = scene.projectors + v;
        forward(NULL, renderer);
        Gradients g = {.patterns = NULL};
        const FfpRenderGradients out = gradients_out(&g);
        const float *maps[FFP_MAP_COUNT];
        for (int m = 0; m < FFP_MAP_COUNT; m++)
            maps[m] = scene.map_weights[m] + v * PIXELS * ffp_map_channels((FfpMap)m);
        require(ffp_renderer_backward(NULL, renderer, scene.weights + v * PATTERNS * PIXELS * 3,
                                      PATTERNS * PIXELS * 3, maps, FFP_MAP_COUNT, &out, &err));
        for (size_t i = 0; i < centres; i++) sum[i] += (double)g.all[0][i];
        for (int k = 0; k < 6; k++) assert_float_equal(g.cameras[k], together.cameras[6 * v + k], 1e-3);
        free_gradients(&g);
    }
    for (size_t i = 0; i < centres; i++) {
        largest = fmax(largest, fabs(sum[i]));
        worst = worse(worst, fabs(sum[i] - (double)together.all[0][i]));
    }
    assert_true(largest > 0 && worst <= 1e-5 * largest);
    free(sum);
    free_gradients(&together), free_gradients(&again);
    ffp_renderer_close(renderer);
}

static void test_any_number_of_threads(void **state) {
    (void)state;
    make_scene(false);
    Gradients g[3];
    for (int threads = 1; threads <= 3; threads++) {
        FfpContextSettings settings = ffp_context_defaults();
        settings.threads = threads;
        FfpContext *context = ffp_context_new(&settings, &err);
        FfpRenderer *renderer = ffp_renderer_new(context, (FfpDrawing){0}, &err);
        forward(context, renderer);
        g[threads - 1] = backward(context, renderer);
        ffp_renderer_close(renderer);
        ffp_context_free(context);
    }
    for (int k = 1; k < 3; k++) {
        for (int a = 0; a < 7; a++)
            assert_memory_equal(g[0].all[a], g[k].all[a],
                                (size_t)(scene.arrays.count * widths[a]) * sizeof(float));
        assert_memory_equal(g[0].cameras, g[k].cameras, sizeof g[0].cameras);
        assert_memory_equal(g[0].projectors, g[k].projectors, sizeof g[0].projectors);
    }
    for (int k = 0; k < 3; k++) free_gradients(&g[k]);
}

// --- What is refused. ---

static void refused(FfpRenderer *renderer, const char *word) {
    assert_false(ffp_renderer_forward(NULL, renderer, &scene.batch, scene.drawn, numbers(), NULL, 0, &err));
    assert_int_equal(err.code, FFP_ERROR_ARGUMENT);
    if (!strstr(err.text, word)) fail_msg("no \"%s\" in: %s", word, err.text);
    make_scene(false);
}

static void test_refused(void **state) {
    (void)state;
    const FfpRenderGradients none = {.patterns = NULL};
    FfpRenderer *renderer = ffp_renderer_new(NULL, (FfpDrawing){0}, &err);
    make_scene(false);
    assert_false(ffp_renderer_backward(NULL, renderer, scene.weights, PICTURES, NULL, 0, &none,
                                       &err)); // nothing drawn
    scene.batch.gradients = false;
    forward(NULL, renderer);
    assert_false(ffp_renderer_backward(NULL, renderer, scene.weights, PICTURES, NULL, 0, &none,
                                       &err)); // not announced
    make_scene(false);
    scene.batch.n_views = 0, refused(renderer, "n_views");
    scene.batch.n_patterns = 1 << 20, refused(renderer, "n_patterns");
    scene.batch.intensity[1] = NAN, refused(renderer, "intensity");
    scene.cameras[2].width++, refused(renderer, "cameras[2]");
    scene.projectors[1].pose[0] = 7, refused(renderer, "projectors[1]");
    scene.pictures[2].width--, scene.pictures[2].row_bytes = 12 * SMALL_PATTERN,
                               refused(renderer, "patterns[2]");
    scene.batch.same_patterns = true, scene.batch.n_patterns = 1, refused(renderer, "same_patterns");
    scene.batch.gaussians.opacity = NULL, refused(renderer, "opacity");
    const float kept = scene.arrays.scale[4];
    scene.arrays.scale[4] = NAN;
    refused(renderer, "row 1");
    scene.arrays.scale[4] = kept;
    // Arrays of other lengths.
    assert_false(
        ffp_renderer_forward(NULL, renderer, &scene.batch, scene.drawn, PICTURES - 1, NULL, 0, &err));
    assert_non_null(strstr(err.text, "(count)"));
    assert_false(ffp_renderer_forward(NULL, renderer, &scene.batch, scene.drawn, PICTURES, scene.map_out,
                                      FFP_MAP_COUNT + 1, &err));
    assert_non_null(strstr(err.text, "(n_maps)"));
    forward(NULL, renderer);
    // After a failure there is no drawing: that before it was of arrays that the caller may have freed.
    scene.batch.n_views = 0, refused(renderer, "n_views");
    assert_false(ffp_renderer_backward(NULL, renderer, scene.weights, PICTURES, NULL, 0, &none, &err));
    forward(NULL, renderer);
    assert_false(ffp_renderer_backward(NULL, renderer, scene.weights, PICTURES + 1, NULL, 0, &none, &err));
    assert_non_null(strstr(err.text, "(count)"));
    assert_false(ffp_renderer_backward(NULL, renderer, scene.weights, PICTURES, NULL, 1, &none, &err));
    assert_non_null(strstr(err.text, "(maps)"));
    // Of a program that knows two maps, no more than these are read.
    float *two[FFP_MAP_COUNT] = {scene.maps[0], scene.maps[1], (float *)1};
    require(ffp_renderer_forward(NULL, renderer, &scene.batch, scene.drawn, PICTURES, two, 2, &err));
    scene.batch.n_patterns = 0; // maps alone
    forward(NULL, renderer);
    require(ffp_renderer_backward(NULL, renderer, NULL, 0, scene.map_in, FFP_MAP_COUNT, &none, &err));
    ffp_renderer_close(renderer);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_as_one_by_one),
        cmocka_unit_test(test_views_add_up),
        cmocka_unit_test(test_any_number_of_threads),
        cmocka_unit_test(test_refused),
        cmocka_unit_test(test_linear_gradients),
        cmocka_unit_test(test_encoded_gradients),
        cmocka_unit_test(test_distortion),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
