// Norms, GELU and convolution of every CPU level that runs here against the portable ones, which the gradient
// tests prove in double. Rows and channels that fill no vector, strides, both directions.
#include <math.h>
#include "core/base/alloc.h"
#include "core/base/cpu.h"
#include "core/tensor/random.h"
#include "core/tensor/tensor.h"
#include "support.h"

enum { ROWS = 67, DIM = 83, LD = DIM + 6, SIZE = ROWS * LD, OUTPUTS = 24 };

// The kernels' outputs, SIZE numbers each. Numbers that they do not write are the same for all.
typedef struct Outputs {
    float *of[OUTPUTS];
    const char *name[OUTPUTS];
    int count;
} Outputs;

// The initial contents of an output: the same at every level.
static float *filled(int index) {
    FfpRng rng = ffp_rng(19, (uint64_t)index);
    return random_reals(&rng, SIZE, 1, 0);
}

static float *output(Outputs *outputs, const char *name) {
    assert_true(outputs->count < OUTPUTS);
    outputs->name[outputs->count] = name;
    outputs->of[outputs->count] = filled(outputs->count);
    return outputs->of[outputs->count++];
}

static void run_norms(Outputs *o, const float *x, const float *z, const float *dy, const float *gain) {
    float *mean = output(o, "mean"), *rstd = output(o, "layernorm rstd");
    ffp_layernorm_forward(output(o, "layernorm"), mean, rstd, x, gain, ROWS, DIM);
    float *dx = output(o, "layernorm dx");
    ffp_layernorm_backward(dx, output(o, "layernorm dgain"), dy, x, mean, rstd, gain, ROWS, DIM);
    rstd = output(o, "rmsnorm rstd");
    ffp_rmsnorm_forward(output(o, "rmsnorm"), rstd, x, gain, ROWS, DIM);
    dx = output(o, "rmsnorm dx");
    ffp_rmsnorm_backward(dx, output(o, "rmsnorm dgain"), dy, x, rstd, gain, ROWS, DIM);
    rstd = output(o, "gated rstd");
    const FfpGatedNorm gated = {x, z, LD, gain, ROWS, DIM};
    ffp_gated_norm_forward(output(o, "gated norm"), rstd, &gated);
    float *dz = output(o, "gated dz");
    dx = output(o, "gated dx");
    const FfpGatedNormGradient grad = {dx, dz, LD, output(o, "gated dgain")};
    ffp_gated_norm_backward(&grad, &gated, dy, rstd);
}

static void run_rest(Outputs *o, const float *x, const float *dy, const float *w, const float *gain) {
    ffp_gelu_forward(output(o, "gelu"), x, SIZE - 5);
    ffp_gelu_backward(output(o, "gelu dx"), dy, x, SIZE - 5);
    for (int taps = 3; taps <= 4; taps++) {
        const FfpDepthwise conv = {x, w, gain, LD, ROWS, DIM, taps, taps == 3};
        ffp_conv_forward(output(o, "conv"), &conv);
        float *dx = output(o, "conv dx"), *dw = output(o, "conv dw");
        const FfpDepthwiseGradient grad = {dx, dw, output(o, "conv dbias"), LD};
        ffp_conv_backward(&grad, &conv, dy);
    }
}

static Outputs run_all(FfpCpuLevel level) {
    FfpRng rng = ffp_rng(20, 0);
    float *x = random_reals(&rng, SIZE, 1, 0.3), *z = random_reals(&rng, SIZE, 2, 0);
    float *dy = random_reals(&rng, SIZE, 1, 0), *w = random_reals(&rng, DIM * 4, 0.5, 0);
    float *gain = random_reals(&rng, DIM, 0.2, 1);
    Outputs outputs = {.count = 0};
    assert_true(ffp_cpu_set_level(level));
    run_norms(&outputs, x, z, dy, gain);
    run_rest(&outputs, x, dy, w, gain);
    ffp_free(x), ffp_free(z), ffp_free(dy), ffp_free(w), ffp_free(gain);
    return outputs;
}

// Sums of up to 83 numbers (norms) or 67 rows (gains), and exponentials within 2e-7 of the true ones: in two
// orders of summation they differ by some 2^-24 sqrt(83) of the whole.
static void check_level(const Outputs *expected, FfpCpuLevel level) {
    Outputs found = run_all(level);
    assert_int_equal(found.count, expected->count);
    for (int i = 0; i < found.count; i++) {
        double error = 0, size = 0;
        float *before = filled(i);
        for (int j = 0; j < SIZE; j++) {
            const double e = (double)expected->of[i][j], difference = (double)found.of[i][j] - e;
            error += difference * difference;
            if (expected->of[i][j] != before[j]) size += e * e;
        }
        ffp_free(before);
        assert_true(size > 0);
        if (!(error <= 1e-12 * size))
            fail_msg("%s, %s: relative error %g", ffp_cpu_name(level), found.name[i], sqrt(error / size));
        ffp_free(found.of[i]);
    }
}

static void levels_agree(void **state) {
    (void)state;
    Outputs expected = run_all(FFP_CPU_PORTABLE);
    for (int level = FFP_CPU_PORTABLE + 1; level <= (int)ffp_cpu_best(); level++)
        check_level(&expected, (FfpCpuLevel)level);
    for (int i = 0; i < expected.count; i++) ffp_free(expected.of[i]);
    ffp_cpu_set_level(ffp_cpu_best());
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(levels_agree)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
