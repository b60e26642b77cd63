// The fp32 kernels against plain double ones, at the sizes the network has.
#include <math.h>
#include <omp.h>
#include "core/base/alloc.h"
#include "core/base/cpu.h"
#include "core/tensor/kernels/fastmath.h"
#include "core/tensor/random.h"
#include "core/tensor/tensor.h"
#include "support.h"

static void exponential(void **state) {
    (void)state;
    double worst = 0;
    for (double x = -87; x <= 88; x += 1e-4) {
        const double expected = exp((double)(float)x);
        worst = worse(worst, fabs((double)ffp_exp((float)x) - expected) / expected);
    }
    printf("exp: worst relative error %.2g\n", worst);
    assert_true(worst < 2e-7);
    assert_true(ffp_exp(0) == 1);
    assert_true(ffp_exp(-INFINITY) >= 0 && ffp_exp(-INFINITY) < 2e-38F);
    assert_true(isfinite(ffp_exp(INFINITY)) && ffp_exp(INFINITY) > 1e38F);
    assert_true(isnan(ffp_exp(NAN)));
}

// SiLU of x in steps of 1e-3 from -100 to 100, by a convolution of one tap with weight 1 at the CPU level in
// use.
static double worst_silu(const float *x, float *y, int rows, int channels, const float *one,
                         const float *zero) {
    double worst = 0;
    const FfpDepthwise conv = {x, one, zero, channels, rows, channels, 1, false};
    ffp_conv_forward(y, &conv);
    for (int i = 0; i < rows * channels; i++) {
        const double at = (double)x[i], expected = at / (1 + exp(-at));
        if (at >= -87)
            worst = worse(worst, fabs((double)y[i] - expected) / (fabs(expected) + 1e-38));
        else
            assert_true(y[i] <= 0 && y[i] > -1e-35F);
    }
    return worst;
}

static void silu(void **state) {
    (void)state;
    enum { ROWS = 4001, CHANNELS = 51 }; // no whole vectors in a row
    float *x = ffp_alloc(ROWS * CHANNELS, sizeof(float)), *y = ffp_alloc(ROWS * CHANNELS, sizeof(float));
    float one[CHANNELS], zero[CHANNELS] = {0};
    for (int i = 0; i < ROWS * CHANNELS; i++) x[i] = (float)(1e-3 * (i % 200001 - 100000));
    for (int c = 0; c < CHANNELS; c++) one[c] = 1;
    for (int level = 0; level <= (int)ffp_cpu_best(); level++) {
        assert_true(ffp_cpu_set_level((FfpCpuLevel)level));
        const double worst = worst_silu(x, y, ROWS, CHANNELS, one, zero);
        printf("silu, %s: worst relative error %.2g\n", ffp_cpu_name((FfpCpuLevel)level), worst);
        assert_true(worst < 4e-7);
        x[60] = NAN;
        const FfpDepthwise conv = {x, one, zero, CHANNELS, ROWS, CHANNELS, 1, true};
        ffp_conv_forward(y, &conv);
        assert_true(isnan(y[60]) && !isnan(y[59]) && !isnan(y[61]));
        x[60] = 0;
    }
    ffp_free(x), ffp_free(y);
}

static void check_normal(void) {
    enum { COUNT = 240001 }; // -12 to 12
    float *x = ffp_alloc(COUNT, sizeof(float)), *y = ffp_alloc(COUNT, sizeof(float));
    float *one = ffp_alloc(COUNT, sizeof(float)), *slope = ffp_alloc(COUNT, sizeof(float)), density;
    double worst = 0, worst_density = 0, worst_gelu = 0, worst_slope = 0;
    for (int i = 0; i < COUNT; i++) x[i] = (float)(1e-4 * i - 12), one[i] = 1;
    ffp_gelu_forward(y, x, COUNT);
    ffp_gelu_backward(slope, one, x, COUNT);
    for (int i = 0; i < COUNT; i++) {
        const double at = (double)x[i], expected = 0.5 * erfc(-at / sqrt(2.0));
        const double peak = exp(-0.5 * at * at) / sqrt(2 * acos(-1.0));
        worst = worse(worst, fabs((double)ffp_normal(x[i], &density) - expected));
        worst_density = worse(worst_density, fabs((double)density - peak));
        worst_gelu = worse(worst_gelu, fabs((double)y[i] - at * expected) / fmax(1, fabs(at)));
        worst_slope = worse(worst_slope, fabs((double)slope[i] - expected - at * peak));
    }
    printf("%s: normal: worst error %.2g, density %.2g, gelu %.2g, its slope %.2g\n",
           ffp_cpu_name(ffp_cpu_level()), worst, worst_density, worst_gelu, worst_slope);
    assert_true(worst < 3e-7 && worst_density < 1e-7 && worst_gelu < 3e-7 && worst_slope < 5e-7);
    assert_true(isnan(ffp_normal(NAN, &density)));
    ffp_free(x), ffp_free(y), ffp_free(one), ffp_free(slope);
}

static void normal_distribution(void **state) {
    (void)state;
    for (int level = 0; level <= (int)ffp_cpu_best(); level++) {
        assert_true(ffp_cpu_set_level((FfpCpuLevel)level));
        check_normal();
    }
}

static float *take(float **next, size_t count) {
    float *taken = *next;
    *next += count;
    return taken;
}

// One pass of every kernel into `out`; returns how many reals it wrote.
static size_t run_everything(float *out) {
    enum { ROWS = 203, HEADS = 3, DIM = HEADS * 32, STATE = 16, LD = DIM + 2 * STATE, TAPS = 4 };
    FfpRng rng = ffp_rng(15, 0);
    const FfpScanShape shape = {
        .rows = ROWS, .heads = HEADS, .head_dim = 32, .state = STATE, .chunk = 64, .reverse = true};
    float *x = random_reals(&rng, ROWS * 3 * DIM, 1, 0), *w = random_reals(&rng, DIM * DIM * 3, 0.1, 0);
    float *gain = random_reals(&rng, LD, 0.1, 1), *dy = random_reals(&rng, ROWS * 3 * DIM, 1, 0);
    const FfpAttentionShape attention = {ROWS, HEADS, 32};
    size_t scratch_size = ffp_scan_scratch(&shape);
    if (scratch_size < ffp_attention_scratch(&attention)) scratch_size = ffp_attention_scratch(&attention);
    float *scratch = ffp_alloc(scratch_size, sizeof(float)), *mean = ffp_alloc(ROWS * HEADS, sizeof(float));
    float *rstd = ffp_alloc(ROWS * HEADS, sizeof(float)), *y = ffp_alloc(ROWS * LD, sizeof(float));
    float *next = out, *dgain;
    ffp_linear_forward(take(&next, ROWS * DIM * 3), x, w, NULL, ROWS, DIM, DIM * 3);
    float *dx = take(&next, ROWS * DIM), *dw = take(&next, DIM * DIM * 3), *dbias = take(&next, DIM * 3);
    ffp_linear_backward(dx, dw, dbias, dy, x, w, ROWS, DIM, DIM * 3);
    ffp_layernorm_forward(take(&next, ROWS * DIM), mean, rstd, x, gain, ROWS, DIM);
    dx = take(&next, ROWS * DIM), dgain = take(&next, DIM);
    ffp_layernorm_backward(dx, dgain, dy, x, mean, rstd, gain, ROWS, DIM);
    const FfpGatedNorm gated = {x, dy, DIM, gain, ROWS, DIM};
    ffp_gated_norm_forward(take(&next, ROWS * DIM), rstd, &gated);
    dx = take(&next, ROWS * DIM), dw = take(&next, ROWS * DIM), dgain = take(&next, DIM);
    ffp_gated_norm_backward(&(FfpGatedNormGradient){dx, dw, DIM, dgain}, &gated, dy, rstd);
    ffp_gelu_forward(take(&next, ROWS * DIM), x, ROWS * DIM);
    ffp_gelu_backward(take(&next, ROWS * DIM), dy, x, ROWS * DIM);
    const FfpDepthwise conv = {x, w, gain, LD, ROWS, LD, TAPS, true};
    ffp_conv_forward(y, &conv);
    dx = take(&next, ROWS * LD), dw = take(&next, LD * TAPS), dbias = take(&next, LD);
    ffp_conv_backward(&(FfpDepthwiseGradient){dx, dw, dbias, LD}, &conv, dy);
    const FfpScanInput in = {y, y + DIM, y + DIM + STATE, LD, x, HEADS, gain, gain + HEADS, gain + 2 * HEADS};
    float *scanned = take(&next, ROWS * DIM), *drow = take(&next, ROWS * LD),
          *ddt = take(&next, ROWS * HEADS), *dsmall = take(&next, 3 * HEADS);
    const FfpScanGradient grad = {drow,   drow + DIM,     drow + DIM + STATE, ddt,
                                  dsmall, dsmall + HEADS, dsmall + 2 * HEADS};
    ffp_scan_forward(scanned, &shape, &in, scratch);
    ffp_scan_backward(&grad, &shape, &in, dy, scratch);
    float *attended = take(&next, ROWS * DIM), *log_sum = take(&next, ROWS * HEADS),
          *dqkv = take(&next, 3 * ROWS * DIM), *dgains = take(&next, 64);
    const FfpAttentionInput qkv = {x, gain, gain};
    const FfpAttentionGradient dattention = {dqkv, dgains, dgains + 32};
    ffp_attention_forward(attended, log_sum, &attention, &qkv, scratch);
    ffp_attention_backward(&dattention, &attention, &qkv, attended, log_sum, dy, scratch);
    float *all[] = {x, w, gain, dy, scratch, mean, rstd, y};
    for (size_t i = 0; i < sizeof(all) / sizeof(all[0]); i++) ffp_free(all[i]);
    return (size_t)(next - out);
}

static void check_same_bits(float *first, float *second, size_t most) {
    memset(first, 0, most * sizeof(float));
    memset(second, 0, most * sizeof(float));
    const size_t used = run_everything(first);
    assert_true(used <= most && run_everything(second) == used);
    for (size_t i = 0; i < used; i++) assert_true(isfinite(first[i]));
    assert_memory_equal(first, second, used * sizeof(float));
}

static void same_bits(void **state) {
    (void)state;
    enum { MOST = 1 << 20 };
    const int threads = omp_get_max_threads();
    float *first = ffp_alloc(MOST, sizeof(float)), *second = ffp_alloc(MOST, sizeof(float));
    for (int level = 0; level <= (int)ffp_cpu_best(); level++) {
        assert_true(ffp_cpu_set_level((FfpCpuLevel)level));
        for (int count = 1; count <= 3; count++) {
            omp_set_num_threads(count);
            check_same_bits(first, second, MOST);
        }
    }
    omp_set_num_threads(threads);
    ffp_free(first), ffp_free(second);
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(exponential), cmocka_unit_test(normal_distribution),
                                       cmocka_unit_test(same_bits), cmocka_unit_test(silu)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
