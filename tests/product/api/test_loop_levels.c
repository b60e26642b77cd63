// The loops that exist once for each CPU level (core/base/level.h): each level gives what the portable one
// gives, but for rounding, and the same bits every time.
#include <math.h>
#include "core/base/arena.h"
#include "core/base/cpu.h"
#include "core/image/lookup.h"
#include "engine/denoise/kernels/kernels.h"
#include "engine/loss/conv.h"
#include "engine/loss/loss.h"
#include "engine/match/kernels/kernels.h"
#include "engine/render/render.h"
#include "engine/render/scenes.h"
#include "support.h"

enum { NUMBERS = 1 << 16 };

// The result of one of the loops.
typedef struct Answer {
    real values[NUMBERS];
    size_t count;
} Answer;

static void give(Answer *answer, const real *values, size_t count) {
    assert_true(answer->count + count <= NUMBERS);
    memcpy(answer->values + answer->count, values, count * sizeof *values);
    answer->count += count;
}

static void fill(real *values, size_t count, uint64_t stream, double low, double high) {
    FfpRng rng = ffp_rng(7, stream);
    for (size_t i = 0; i < count; i++) values[i] = between(&rng, low, high);
}

static FfpImage random_image(int width, int height, int channels, uint64_t stream) {
    FfpImage image = ffp_image_new(width, height, channels);
    fill(image.data, (size_t)width * (size_t)height * (size_t)channels, stream, 0.05, 1);
    return image;
}

static void similarity(Answer *answer) {
    FfpImage a = random_image(37, 29, 3, 1), b = random_image(37, 29, 3, 2), grad = ffp_image_new(37, 29, 3);
    const real loss = ffp_ssim_loss(&a, &b, 1, &grad);
    give(answer, &loss, 1);
    give(answer, grad.data, 37 * 29 * 3);
    ffp_image_free(&a), ffp_image_free(&b), ffp_image_free(&grad);
}

static void convolution(Answer *answer) {
    enum { IN = 5, OUT = 7, W = 23, H = 18 };
    const FfpConv conv = {.in = IN, .out = OUT, .kernel = 3, .stride = 1, .pad = 1, .width = W, .height = H};
    const FfpPool pool = {
        .channels = OUT, .kernel = 3, .stride = 2, .round_up = true, .width = W, .height = H};
    static real x[IN * W * H], w[OUT * IN * 9], bias[OUT], y[OUT * W * H], less[OUT * W * H], dy[OUT * W * H];
    fill(x, IN * W * H, 3, -1, 1), fill(w, OUT * IN * 9, 4, -1, 1), fill(bias, OUT, 5, -1, 1);
    ffp_conv2d_forward(y, OUT * W * H, x, IN * W * H, w, bias, &conv, 1);
    ffp_maxpool_forward(less, y, &pool);
    give(answer, y, OUT * W * H);
    const size_t few =
        (size_t)OUT * (size_t)ffp_pool_side(W, 3, 2, true) * (size_t)ffp_pool_side(H, 3, 2, true);
    give(answer, less, few);
    memset(dy, 0, sizeof dy), memset(x, 0, sizeof x);
    ffp_maxpool_backward(dy, less, y, &pool);
    ffp_conv2d_backward(x, dy, y, w, &conv);
    give(answer, x, IN * W * H);
}

static void planes(Answer *answer) {
    enum { W = 40, H = 24 };
    const real eye[3] = {3, 0, 0}, origin[3] = {0};
    const FfpCamera camera = look_at(W, H, 60, eye, origin);
    static real depth[W * H], weight[W * H];
    fill(depth, W * H, 6, 2.9, 3), fill(weight, W * H, 7, 0.1, 1);
    FfpSheet sheet = ffp_sheet_new(depth, weight, &camera, 2);
    for (int y = 0; y < H; y++)
        for (int x = 0; x < W; x += FFP_MATCH_LANES) {
            FfpPlane fit[FFP_MATCH_LANES];
            ffp_fit_planes(fit, &sheet, x, y);
            for (int n = 0; n < FFP_MATCH_LANES; n++) give(answer, &fit[n].q0, 1);
        }
    ffp_sheet_free(&sheet);
}

static void paths(Answer *answer) {
    enum { W = 19, H = 13, N = 37 };
    FfpImage coverage = random_image(W, H, 1, 8);
    FfpForeground foreground = ffp_foreground_new(&coverage);
    const size_t count = foreground.count * N;
    real *cost = ffp_alloc(count, sizeof *cost), *total = ffp_alloc(count, sizeof *total);
    fill(cost, count, 9, 0, 1);
    ffp_semi_global(total, cost, &foreground, N, &(FfpSteps){.small = 0.1F, .large = 0.4F});
    give(answer, total, count);
    ffp_free(cost), ffp_free(total);
    ffp_foreground_free(&foreground), ffp_image_free(&coverage);
}

static void photographs(Answer *answer) {
    enum { W = 21, H = 13, COUNT = W * H, LINE = 6 };
    static FfpStereoCell own[COUNT], theirs[COUNT];
    static real line[LINE][COUNT], single[COUNT];
    static size_t pixel[COUNT];
    for (int i = 0; i < COUNT; i++) {
        real cells[2 * FFP_STEREO_CHANNELS];
        fill(cells, 2 * FFP_STEREO_CHANNELS, 60 + (uint64_t)i, 0, 0.3);
        for (int c = 0; c < FFP_STEREO_CHANNELS; c++) own[i][c] = cells[c], theirs[i][c] = cells[8 + c];
        pixel[i] = (size_t)i;
    }
    for (int k = 0; k < LINE; k++) fill(line[k], COUNT, 50 + (uint64_t)k, k < 4 ? -1 : 0.2, k < 4 ? 12 : 1);
    FfpStereoPlane plane = {.count = COUNT,
                            .pixel = pixel,
                            .at = 0.7F,
                            .own = own,
                            .theirs = theirs,
                            .weight = {0.2F, 0.1F, 0.1F, 0.2F, 0.1F, 0.1F, 0.2F},
                            .width = W,
                            .right = W - 1,
                            .bottom = H - 1};
    for (int k = 0; k < LINE; k++) plane.line[k] = line[k];
    ffp_stereo_plane(single, &plane);
    give(answer, single, COUNT);
}

static void light(Answer *answer) {
    enum { W = 48, H = 40 };
    const real eye[3] = {3, 0, 0}, above[3] = {2, 0.5F, 1.5F}, origin[3] = {0}, intensity[3] = {7, 8, 9};
    const FfpCamera camera = look_at(W, H, 50, eye, origin), projector = look_at(64, 64, 50, above, origin);
    const FfpRenderSettings settings = ffp_render_defaults();
    FfpGaussians splats = random_gaussians(900, 10, 0.6, 0.02, 0.08, 0.5, 0.9);
    FfpRaster *raster = ffp_raster_new();
    FfpGbuffer drawn = ffp_gbuffer_new(W, H), grad = ffp_gbuffer_new(W, H);
    FfpMapping mapping = ffp_mapping_new(W, H);
    FfpImage rgb = random_image(64, 64, 3, 11), picture = ffp_image_new(W, H, 3),
             weights = random_image(W, H, 3, 12);
    FfpSummed pattern = ffp_summed_new(&rgb);
    real grad_intensity[3] = {0};
    // Drawn by the same level, so that only what follows differs: drawing has a test of its own.
    const FfpCpuLevel level = ffp_cpu_level();
    assert_true(ffp_cpu_set_level(FFP_CPU_PORTABLE));
    ffp_rasterise(raster, &splats, &camera, &settings, &drawn);
    FfpGbuffer shadow = ffp_shadow_map(raster, &splats, &projector, &settings);
    assert_true(ffp_cpu_set_level(level));
    ffp_map_with_shadow(&shadow, &drawn, &camera, &projector, &settings, &mapping);
    FfpTransport transport = ffp_transport_new(W, H), d = ffp_transport_new(W, H);
    ffp_light(&drawn, &mapping, &camera, &projector, &transport);
    ffp_shade(&drawn, &mapping, &transport, intensity, &pattern, &picture);
    ffp_shade_backward(&mapping, &transport, intensity, &pattern, &weights, &grad, &d, grad_intensity, NULL);
    ffp_light_backward(&drawn, &mapping, &camera, &projector, &d, &grad);
    ffp_transport_free(&transport), ffp_transport_free(&d);
    give(answer, mapping.visibility, W * H), give(answer, picture.data, W * H * 3);
    give(answer, grad.albedo, W * H * 3), give(answer, grad.normal, W * H * 3);
    give(answer, grad_intensity, 3);
    ffp_gaussians_free(&splats), ffp_raster_free(raster), ffp_mapping_free(&mapping);
    ffp_gbuffer_free(&drawn), ffp_gbuffer_free(&grad), ffp_summed_free(&pattern);
    ffp_image_free(&rgb), ffp_image_free(&picture), ffp_image_free(&weights);
}

static void smoothing(Answer *answer) {
    enum { W = 16, H = 12, STRIDE = 2 };
    static real stack[W * H * FFP_VALUES], coverage[W * H];
    static FfpWindow windows[(W / STRIDE) * (H / STRIDE)];
    fill(stack, W * H * FFP_VALUES, 30, 0, 1), fill(coverage, W * H, 31, 0.2, 1);
    for (size_t i = 0; i < sizeof windows / sizeof windows[0]; i++)
        fill(&windows[i].weight, sizeof windows[i] / sizeof(real), 40 + i, 0.1, 0.3);
    const FfpFilter filter = {.width = W,
                              .height = H,
                              .stride = STRIDE,
                              .across = W / STRIDE,
                              .down = H / STRIDE,
                              .rows = H / STRIDE,
                              .stack = stack,
                              .coverage = coverage,
                              .windows = windows};
    for (int i = 0; i < W * H; i++) {
        real values[FFP_VALUES];
        ffp_denoise_kernels()->smooth(&filter, i % W, i / W, values);
        give(answer, values, FFP_VALUES);
    }
}

static const struct {
    const char *name;
    void (*run)(Answer *answer);
} loops[] = {
    {"similarity", similarity}, {"convolution", convolution}, {"planes", planes},
    {"paths", paths},           {"photographs", photographs}, {"light", light},
    {"smoothing", smoothing},
};

static double share_off(const Answer *a, const Answer *b) {
    double off = 0, all = 0;
    for (size_t i = 0; i < b->count; i++) {
        const double d = (double)a->values[i] - (double)b->values[i];
        off += d * d, all += (double)b->values[i] * (double)b->values[i];
    }
    return sqrt(off / all);
}

static void test_levels_agree(void **state) {
    (void)state;
    const FfpCpuLevel used = ffp_cpu_level();
    Answer *plain = ffp_alloc(3, sizeof *plain), *fast = plain + 1, *again = plain + 2;
    for (size_t n = 0; n < sizeof loops / sizeof loops[0]; n++) {
        plain->count = 0;
        assert_true(ffp_cpu_set_level(FFP_CPU_PORTABLE));
        loops[n].run(plain);
        assert_true(plain->count > 0);
        for (int level = 0; level <= (int)ffp_cpu_best(); level++) {
            fast->count = again->count = 0;
            assert_true(ffp_cpu_set_level((FfpCpuLevel)level));
            loops[n].run(fast);
            loops[n].run(again);
            assert_int_equal(fast->count, plain->count);
            assert_memory_equal(fast->values, again->values, fast->count * sizeof(real));
            const double off = share_off(fast, plain);
            if (!(off < 1e-4))
                fail_msg("%s, %s: off by %g", loops[n].name, ffp_cpu_name((FfpCpuLevel)level), off);
        }
    }
    ffp_free(plain);
    assert_true(ffp_cpu_set_level(used));
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_levels_agree)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
