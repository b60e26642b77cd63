// The tensor room's kernels on the device against the portable ones of the CPU: odd shapes, strides, both
// directions, outputs that hold something before. FFP_LARGE in the environment adds the sizes of networks.
#include <math.h>
#include "core/base/alloc.h"
#include "core/base/cpu.h"
#include "core/tensor/adam.h"
#include "core/tensor/random.h"
#include "core/tensor/tensor.h"
#include "engine/cuda/cuda.h"
#include "engine/cuda/tensor.h"
#include "support.h"

enum { OUTPUTS = 16, BLOCKS = 64 };
#define FP32 1e-4
#define BF16 1e-2

// One pass of some kernels, on the CPU or on the device. Inputs are the same in every pass.
typedef struct Pass {
    FfpRng rng;
    void *blocks[BLOCKS]; // where the pass works
    int n_blocks;
    struct {
        const char *name;
        float *there, *before, *after; // where the pass works; on the host
        size_t count;
        double bound;
    } out[OUTPUTS];
    int n_out;
} Pass;

static void *keep(Pass *pass, void *block) {
    assert_true(pass->n_blocks < BLOCKS);
    return pass->blocks[pass->n_blocks++] = block;
}

static float *input(Pass *pass, size_t count, double scale, double shift) {
    float *host = random_reals(&pass->rng, count, scale, shift);
    float *there = keep(pass, ffp_memory_uploaded(host, count, sizeof *host));
    ffp_free(host);
    return there;
}

static float *register_output(Pass *pass, const char *name, size_t count, double bound, float *before) {
    assert_true(pass->n_out < OUTPUTS);
    const int i = pass->n_out++;
    pass->out[i].name = name, pass->out[i].count = count, pass->out[i].bound = bound;
    pass->out[i].before = before;
    return pass->out[i].there = keep(pass, ffp_memory_uploaded(before, count, sizeof *before));
}

// Must be written whole: NaN before.
static float *output(Pass *pass, const char *name, size_t count, double bound) {
    float *before = ffp_alloc(count, sizeof *before);
    for (size_t i = 0; i < count; i++) before[i] = NAN;
    return register_output(pass, name, count, bound, before);
}

// Is added to, or written in parts.
static float *sum(Pass *pass, const char *name, size_t count, double bound) {
    return register_output(pass, name, count, bound, random_reals(&pass->rng, count, 1, 0));
}

static float *scratch(Pass *pass, size_t count) {
    float *nans = ffp_alloc(count, sizeof *nans);
    for (size_t i = 0; i < count; i++) nans[i] = NAN;
    float *there = keep(pass, ffp_memory_uploaded(nans, count, sizeof *nans));
    ffp_free(nans);
    return there;
}

typedef void Kernels(Pass *pass, const void *shape);

static Pass run(Kernels *kernels, const void *shape, const FfpDevice *device) {
    Pass pass = {.rng = ffp_rng(31, 7)};
    ffp_device_use(device);
    kernels(&pass, shape);
    for (int i = 0; i < pass.n_out; i++) {
        pass.out[i].after = ffp_alloc(pass.out[i].count, sizeof(float));
        ffp_memory_download(pass.out[i].after, pass.out[i].there, pass.out[i].count * sizeof(float));
    }
    for (int i = 0; i < pass.n_blocks; i++) ffp_memory_free(pass.blocks[i]);
    ffp_device_use(NULL);
    return pass;
}

static void free_outputs(Pass *pass) {
    for (int i = 0; i < pass->n_out; i++) ffp_free(pass->out[i].before), ffp_free(pass->out[i].after);
}

// The values from before are subtracted: only what the kernels add counts.
static double relative_error(const float *found, const float *expected, const float *before, size_t count) {
    double error = 0, size = 0;
    for (size_t i = 0; i < count; i++) {
        const double start = isnan(before[i]) ? 0 : (double)before[i];
        const double difference = (double)found[i] - (double)expected[i], added = (double)expected[i] - start;
        error += difference * difference, size += added * added;
    }
    return sqrt(error / fmax(size, 1e-30));
}

static void check(const char *what, Kernels *kernels, const void *shape) {
    FfpError err = {0};
    const FfpDevice *device = ffp_cuda_device(&err);
    if (!device) {
        print_message("%s\n", err.text);
        skip();
    }
    Pass expected = run(kernels, shape, NULL), found = run(kernels, shape, device),
         again = run(kernels, shape, device);
    bool good = true;
    for (int i = 0; i < found.n_out; i++) {
        const size_t count = found.out[i].count;
        const double error =
            relative_error(found.out[i].after, expected.out[i].after, found.out[i].before, count);
        const bool same = memcmp(found.out[i].after, again.out[i].after, count * sizeof(float)) == 0;
        const bool close = error <= found.out[i].bound; // false for NaN
        if (!close || !same || getenv("FFP_LARGE"))
            print_message("%s, %s: relative error %.2g, at most %g%s\n", what, found.out[i].name, error,
                          found.out[i].bound, same ? "" : "; not the same bits again");
        good = good && close && same;
    }
    free_outputs(&expected), free_outputs(&found), free_outputs(&again);
    assert_true(good);
}

typedef struct Product {
    int m, n, k, more; // more: what row strides have beyond the width
    bool transpose_a, transpose_b, mixed;
    float alpha, beta;
} Product;

static FfpFactor product_factor(Pass *pass, int rows, int columns, int more, bool transposed, double shift) {
    if (transposed) return ffp_transposed(product_factor(pass, columns, rows, more, false, shift));
    return ffp_factor(input(pass, (size_t)rows * (columns + more), 1, shift), rows, columns, columns + more);
}

static void product(Pass *pass, const void *shape) {
    const Product *p = shape;
    const FfpFactor a = product_factor(pass, p->m, p->k, p->more, p->transpose_a, 0.1);
    const FfpFactor b = product_factor(pass, p->k, p->n, p->more, p->transpose_b, -0.1);
    const int ldc = p->n + p->more;
    const size_t size = (size_t)p->m * ldc;
    float *c = p->beta == 0 && p->more == 0 ? output(pass, "c", size, p->mixed ? BF16 : FP32)
                                            : sum(pass, "c", size, p->mixed ? BF16 : FP32);
    (p->mixed ? ffp_gemm_mixed : ffp_gemm)(p->alpha, a, b, p->beta, c, ldc);
}

static void products(void **state) {
    (void)state;
    for (int bits = 0; bits < 8; bits++) {
        Product p = {37, 29, 53, 0, bits & 1, bits & 2, bits & 4, 1, 0};
        check("product", product, &p);
        p = (Product){5, 70, 19, 3, bits & 1, bits & 2, bits & 4, 0.5F, 2};
        check("product", product, &p);
        p = (Product){64, 8, 32, 4, bits & 1, bits & 2, bits & 4, -1, 1};
        check("product", product, &p);
        if (!getenv("FFP_LARGE")) continue;
        p = (Product){1536, 2048, 1676, 0, bits & 1, bits & 2, bits & 4, 1, 0};
        check("large product", product, &p);
    }
}

typedef struct Layer {
    int rows, in, out;
} Layer;

static void linear(Pass *pass, const void *shape) {
    const Layer *l = shape;
    const size_t rows = (size_t)l->rows, in = (size_t)l->in, out = (size_t)l->out;
    const float *x = input(pass, rows * in, 1, 0), *w = input(pass, out * in, 0.1, 0);
    const float *bias = input(pass, out, 1, 0), *dy = input(pass, rows * out, 1, 0),
                *residual = input(pass, rows * out, 1, 0);
    ffp_linear_forward(output(pass, "y", rows * out, BF16), x, w, NULL, l->rows, l->in, l->out);
    ffp_linear_forward(output(pass, "y with bias", rows * out, BF16), x, w, bias, l->rows, l->in, l->out);
    ffp_linear_residual_forward(output(pass, "residual + y", rows * out, BF16), residual, x, w, l->rows,
                                l->in, l->out);
    float *in_place = sum(pass, "y in place", rows * out, BF16);
    ffp_linear_residual_forward(in_place, in_place, x, w, l->rows, l->in, l->out);
    float *dx = output(pass, "dx", rows * in, BF16), *dw = sum(pass, "dw", out * in, BF16);
    ffp_linear_backward(dx, dw, sum(pass, "dbias", out, FP32), dy, x, w, l->rows, l->in, l->out);
    dw = sum(pass, "dw alone", out * in, BF16);
    ffp_linear_backward(NULL, dw, NULL, dy, x, w, l->rows, l->in, l->out);
}

static void linear_layers(void **state) {
    (void)state;
    const Layer layers[] = {{67, 54, 33},      {1, 7, 5},          {40, 64, 128},  {300, 24, 20},
                            {2048, 384, 1676}, {2048, 1024, 4096}, {40000, 54, 96}};
    for (int i = 0; i < (getenv("FFP_LARGE") ? 7 : 4); i++) check("linear", linear, &layers[i]);
}

typedef struct Matrix {
    int rows, dim, more;
} Matrix;

static void norms(Pass *pass, const void *shape) {
    const Matrix *m = shape;
    const int rows = m->rows, dim = m->dim;
    const size_t size = (size_t)rows * dim;
    const float *x = input(pass, size, 1, 0.3), *dy = input(pass, size, 1, 0);
    const float *gain = input(pass, (size_t)dim, 0.2, 1);
    float *mean = output(pass, "mean", (size_t)rows, FP32),
          *rstd = output(pass, "layernorm rstd", (size_t)rows, FP32);
    ffp_layernorm_forward(output(pass, "layernorm", size, FP32), mean, rstd, x, gain, rows, dim);
    float *dx = output(pass, "layernorm dx", size, FP32),
          *dgain = sum(pass, "layernorm dgain", (size_t)dim, FP32);
    ffp_layernorm_backward(dx, dgain, dy, x, mean, rstd, gain, rows, dim);
    rstd = output(pass, "rmsnorm rstd", (size_t)rows, FP32);
    ffp_rmsnorm_forward(output(pass, "rmsnorm", size, FP32), rstd, x, gain, rows, dim);
    dx = output(pass, "rmsnorm dx", size, FP32), dgain = sum(pass, "rmsnorm dgain", (size_t)dim, FP32);
    ffp_rmsnorm_backward(dx, dgain, dy, x, rstd, gain, rows, dim);
}

static void gated_norm(Pass *pass, const void *shape) {
    const Matrix *m = shape;
    const int rows = m->rows, dim = m->dim, ldz = dim + m->more, lddz = dim + 2 * m->more;
    const size_t size = (size_t)rows * dim;
    const float *x = input(pass, size, 1, 0.3), *dy = input(pass, size, 1, 0);
    const float *z = input(pass, (size_t)rows * ldz, 2, 0), *gain = input(pass, (size_t)dim, 0.2, 1);
    float *rstd = output(pass, "rstd", (size_t)rows, FP32);
    const FfpGatedNorm in = {x, z, ldz, gain, rows, dim};
    ffp_gated_norm_forward(output(pass, "gated norm", size, FP32), rstd, &in);
    float *dx = output(pass, "gated dx", size, FP32), *dz = sum(pass, "gated dz", (size_t)rows * lddz, FP32);
    const FfpGatedNormGradient grad = {dx, dz, lddz, sum(pass, "gated dgain", (size_t)dim, FP32)};
    ffp_gated_norm_backward(&grad, &in, dy, rstd);
}

static void elementwise(Pass *pass, const void *shape) {
    const Matrix *m = shape;
    const size_t size = (size_t)m->rows * m->dim, shift = (size_t)m->more;
    const float *x = input(pass, size + shift, 1.5, 0), *dy = input(pass, size + shift, 1, 0);
    ffp_add(sum(pass, "added", size, FP32), x + shift, size);
    ffp_gelu_forward(output(pass, "gelu", size, FP32), x + shift, size);
    ffp_gelu_backward(output(pass, "gelu dx", size, FP32), dy, x, size);
}

static void rows_and_numbers(void **state) {
    (void)state;
    const Matrix shapes[] = {{67, 83, 6},  {1, 3, 0},         {19, 384, 5},      {3, 1500, 1},
                             {530, 12, 3}, {2048, 384, 1292}, {2048, 1024, 640}, {2048, 4096, 0}};
    for (int i = 0; i < (getenv("FFP_LARGE") ? 8 : 5); i++) {
        check("norms", norms, &shapes[i]);
        check("gated norm", gated_norm, &shapes[i]);
        check("elementwise", elementwise, &shapes[i]);
    }
}

typedef struct Conv {
    int rows, channels, more, taps;
    bool reverse;
} Conv;

static void conv(Pass *pass, const void *shape) {
    const Conv *c = shape;
    const int rows = c->rows, channels = c->channels, ldx = channels + c->more, lddx = channels + 2 * c->more;
    const size_t size = (size_t)rows * channels, weights = (size_t)channels * c->taps;
    const float *x = input(pass, (size_t)rows * ldx, 1, 0), *dy = input(pass, size, 1, 0);
    const float *w = input(pass, weights, 0.5, 0), *bias = input(pass, (size_t)channels, 0.5, 0);
    const FfpDepthwise in = {x, w, bias, ldx, rows, channels, c->taps, c->reverse};
    ffp_conv_forward(output(pass, "conv", size, FP32), &in);
    float *dx = sum(pass, "conv dx", (size_t)rows * lddx, FP32), *dw = sum(pass, "conv dw", weights, FP32);
    const FfpDepthwiseGradient grad = {dx, dw, sum(pass, "conv dbias", (size_t)channels, FP32), lddx};
    ffp_conv_backward(&grad, &in, dy);
}

static void convolutions(void **state) {
    (void)state;
    for (int reverse = 0; reverse < 2; reverse++) {
        const Conv shapes[] = {{67, 83, 5, 4, reverse},       {33, 129, 0, 3, reverse},
                               {2, 4, 1, 4, reverse},         {50, 9, 2, 7, reverse},
                               {16, 20, 2, 1, reverse},       {2048, 896, 780, 4, reverse},
                               {2048, 2304, 2080, 4, reverse}};
        for (int i = 0; i < (getenv("FFP_LARGE") ? 7 : 5); i++) check("conv", conv, &shapes[i]);
    }
}

// A in 1..16 and dt in 1e-3..1e-1 and beyond, as a network has them.
static void scan(Pass *pass, const void *shape) {
    const FfpScanShape *s = shape;
    const size_t rows = (size_t)s->rows, heads = (size_t)s->heads, width = heads * (size_t)s->head_dim,
                 state = (size_t)s->state, ld = width + 2 * state, lddt = heads + 3;
    const float *row = input(pass, rows * ld, 0.5, 0), *dt = input(pass, rows * lddt, 1, 0);
    const float *bias = input(pass, heads, 1, -3), *a_log = input(pass, heads, 0.8, 1),
                *d = input(pass, heads, 0.3, 1), *dy = input(pass, rows * width, 1, 0);
    const FfpScanInput in = {row, row + width, row + width + state, (int)ld, dt, (int)lddt, bias, a_log, d};
    const size_t size = ffp_scan_scratch(s);
    float *y = output(pass, "y", rows * width, FP32);
    ffp_scan_forward(y, s, &in, scratch(pass, size));
    float *drow = output(pass, "dx, dB, dC", rows * ld, FP32);
    const FfpScanGradient grad = {drow,
                                  drow + width,
                                  drow + width + state,
                                  sum(pass, "ddt", rows * lddt, FP32),
                                  sum(pass, "ddt_bias", heads, FP32),
                                  sum(pass, "da_log", heads, FP32),
                                  sum(pass, "dd", heads, FP32)};
    ffp_scan_backward(&grad, s, &in, dy, scratch(pass, size));
}

static void scans(void **state) {
    (void)state;
    for (int reverse = 0; reverse < 2; reverse++) {
        const FfpScanShape shapes[] = {{150, 2, 64, 64, 64, reverse},   {65, 3, 33, 17, 16, reverse},
                                       {63, 1, 8, 100, 64, reverse},    {130, 1, 64, 128, 64, reverse},
                                       {1, 2, 5, 3, 64, reverse},       {700, 1, 4, 5, 64, reverse},
                                       {2048, 12, 64, 64, 64, reverse}, {2047, 32, 64, 128, 64, reverse}};
        for (int i = 0; i < (getenv("FFP_LARGE") ? 8 : 6); i++)
            check(reverse ? "scan reversed" : "scan", scan, &shapes[i]);
    }
}

// Decays of e^-1000 a step and of none at all must neither overflow nor become NaN. Gradients of steps are
// small differences then, of which the last bits count.
static void scan_extremes(Pass *pass, const void *shape) {
    enum { ROWS = 100, DIM = 8, STATE = 8, LD = DIM + 2 * STATE };
    const FfpScanShape s = {ROWS, 1, DIM, STATE, 64, *(const bool *)shape};
    float steps[ROWS];
    for (int t = 0; t < ROWS; t++) steps[t] = t % 3 == 0 ? 60.0F : -120.0F;
    const float *row = input(pass, ROWS * LD, 0.5, 0), *dy = input(pass, ROWS * DIM, 1, 0),
                *dt = keep(pass, ffp_memory_uploaded(steps, ROWS, sizeof *steps)),
                *zero = input(pass, 1, 0, 0), *a_log = input(pass, 1, 0, log(16.0)),
                *d = input(pass, 1, 0, 1);
    const FfpScanInput in = {row, row + DIM, row + DIM + STATE, LD, dt, 1, zero, a_log, d};
    const size_t size = ffp_scan_scratch(&s);
    float *y = output(pass, "y", ROWS * DIM, FP32), *drow = output(pass, "dx, dB, dC", ROWS * LD, FP32),
          *small = sum(pass, "ddt_bias, da_log, dd", 3, (double)INFINITY);
    ffp_scan_forward(y, &s, &in, scratch(pass, size));
    const FfpScanGradient grad = {drow,  drow + DIM, drow + DIM + STATE, sum(pass, "ddt", ROWS, 1e-3),
                                  small, small + 1,  small + 2};
    ffp_scan_backward(&grad, &s, &in, dy, scratch(pass, size));
}

static void extreme_scans(void **state) {
    (void)state;
    for (int reverse = 0; reverse < 2; reverse++) {
        const bool backwards = reverse == 1;
        check("extreme scan", scan_extremes, &backwards);
    }
}

static void attention(Pass *pass, const void *shape) {
    const FfpAttentionShape *a = shape;
    const size_t rows = (size_t)a->rows, heads = (size_t)a->heads, dim = (size_t)a->head_dim,
                 width = heads * dim;
    const float *qkv = input(pass, rows * 3 * width, 1, 0), *q_gain = input(pass, dim, 0.2, 1),
                *k_gain = input(pass, dim, 0.2, 1), *dout = input(pass, rows * width, 1, 0);
    const FfpAttentionInput in = {qkv, q_gain, k_gain};
    const size_t size = ffp_attention_scratch(a);
    float *out = output(pass, "attention", rows * width, BF16),
          *log_sum = output(pass, "log_sum", rows * heads, BF16);
    ffp_attention_forward(out, log_sum, a, &in, scratch(pass, size));
    float *dqkv = output(pass, "dqkv", rows * 3 * width, BF16), *dq_gain = sum(pass, "dq_gain", dim, BF16);
    const FfpAttentionGradient grad = {dqkv, dq_gain, sum(pass, "dk_gain", dim, BF16)};
    ffp_attention_backward(&grad, a, &in, out, log_sum, dout, scratch(pass, size));
}

static void attentions(void **state) {
    (void)state;
    const FfpAttentionShape shapes[] = {{37, 2, 64},   {130, 1, 24},  {2, 3, 13},    {65, 3, 40},
                                        {100, 1, 128}, {2048, 6, 64}, {2047, 16, 64}};
    for (int i = 0; i < (getenv("FFP_LARGE") ? 7 : 5); i++) check("attention", attention, &shapes[i]);
}

static void optimiser(Pass *pass, const void *shape) {
    const int *count = shape;
    const size_t n = (size_t)*count;
    FfpAdamArray a = {.step = ffp_adam_step(0.05, 0.9, 0.99, 1e-3, 2), .count = *count};
    a.grad = input(pass, n, 1, 0), a.start = input(pass, n, 1, 0);
    a.x = sum(pass, "x", n, FP32), a.mean = sum(pass, "mean", n, FP32);
    a.square = keep(pass, ffp_memory_new(n, sizeof(float))), a.average = sum(pass, "average", n, FP32);
    a.step.decay = 0.1F, a.step.pull = 0.2F, a.step.average = 0.75F, a.step.scale = 0.5F;
    FfpAdamArray plain = a;
    plain.step.sparse = true, plain.start = NULL, plain.average = NULL;
    plain.x = sum(pass, "plain x", n, FP32), plain.mean = sum(pass, "plain mean", n, FP32);
    plain.square = keep(pass, ffp_memory_new(n, sizeof(float)));
    ffp_adam((const FfpAdamArray[]){a, plain}, 2);
    float *norm = output(pass, "norm", 1, FP32);
    const float sum_of_squares = (float)ffp_squared_norm(a.grad, *count);
    ffp_memory_upload(norm, &sum_of_squares, sizeof sum_of_squares);
}

static void optimisers(void **state) {
    (void)state;
    const int counts[] = {1, 1003, 200000};
    for (int i = 0; i < 3; i++) check("Adam", optimiser, &counts[i]);
}

int main(void) {
    ffp_cpu_set_level(FFP_CPU_PORTABLE);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(products),     cmocka_unit_test(linear_layers), cmocka_unit_test(rows_and_numbers),
        cmocka_unit_test(convolutions), cmocka_unit_test(scans),         cmocka_unit_test(extreme_scans),
        cmocka_unit_test(attentions),   cmocka_unit_test(optimisers)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
