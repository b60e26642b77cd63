// Times the tensor room's kernels on the device at the sizes of networks, against a large product and a copy
// of the same run. On the emulated device the sizes are tiny and the times mean nothing.
#include "bench/gpu_timing.h"
#include "core/base/arena.h"
#include "core/base/rng.h"
#include "core/tensor/tensor.h"
#include "engine/cuda/products.h"
#include "engine/network/layout.h"

enum { RUNS = 30 }; // queued together

// A network's sizes, and arrays on the device that are large enough for each of its kernels.
struct Bench {
    const char *name;
    int rows;
    FfpWidths w;
    size_t most;
    float *a, *b, *c, *d, *weight, *dweight; // [most]
    float *small, *dsmall, *row, *row2;      // [16384], [16384], [rows * heads]
    float *scratch;
};

static double product_peak = 1, copy_peak = 1; // operations and bytes a second

static double seconds(void (*run)(Bench *), Bench *data) {
    return gpu_seconds(run, data, RUNS);
}

static void linear_forward(Bench *x, int in, int out) {
    ffp_linear_forward(x->c, x->a, x->weight, NULL, x->rows, in, out);
}
static void linear_backward(Bench *x, int in, int out) {
    ffp_linear_backward(x->c, x->dweight, NULL, x->b, x->a, x->weight, x->rows, in, out);
}
static void in_proj(Bench *x) {
    linear_forward(x, x->w.dim, x->w.projected);
}
static void in_proj_back(Bench *x) {
    linear_backward(x, x->w.dim, x->w.projected);
}
static void out_proj(Bench *x) {
    ffp_linear_residual_forward(x->c, x->b, x->a, x->weight, x->rows, x->w.inner, x->w.dim);
}
static void out_proj_back(Bench *x) {
    linear_backward(x, x->w.inner, x->w.dim);
}
static void fc1(Bench *x) {
    linear_forward(x, x->w.dim, FFP_MLP_RATIO * x->w.dim);
}
static void fc1_back(Bench *x) {
    linear_backward(x, x->w.dim, FFP_MLP_RATIO * x->w.dim);
}
static void gemm(Bench *x) {
    const int dim = x->w.dim, wide = FFP_MLP_RATIO * dim;
    ffp_gemm(1, ffp_factor(x->a, x->rows, dim, dim), ffp_transposed(ffp_factor(x->weight, wide, dim, dim)), 0,
             x->c, wide);
}
static void bias_back(Bench *x) {
    ffp_linear_backward(NULL, x->dweight, x->dsmall, x->b, x->a, x->weight, x->rows, 8,
                        FFP_MLP_RATIO * x->w.dim);
}
static FfpAttentionShape attention_shape(const Bench *x) {
    return (FfpAttentionShape){.rows = x->rows, .heads = x->w.attention_heads, .head_dim = FFP_HEAD_DIM};
}
static void attention(Bench *x) {
    const FfpAttentionShape shape = attention_shape(x);
    const FfpAttentionInput in = {x->a, x->small, x->small};
    ffp_attention_forward(x->c, x->row, &shape, &in, x->scratch);
}
static void attention_back(Bench *x) {
    const FfpAttentionShape shape = attention_shape(x);
    const FfpAttentionInput in = {x->a, x->small, x->small};
    const FfpAttentionGradient grad = {x->d, x->dsmall, x->dsmall + FFP_HEAD_DIM};
    ffp_attention_backward(&grad, &shape, &in, x->c, x->row, x->b, x->scratch);
}
static FfpScanShape scan_shape(Bench *x) {
    return (FfpScanShape){.rows = x->rows,
                          .heads = x->w.scan_heads,
                          .head_dim = FFP_HEAD_DIM,
                          .state = x->w.state,
                          .chunk = x->w.chunk};
}
static FfpScanInput scan_input(Bench *x) {
    return (FfpScanInput){.x = x->a,
                          .b = x->a + x->w.inner,
                          .c = x->a + x->w.inner + x->w.state,
                          .ld = x->w.convolved,
                          .dt_raw = x->b,
                          .lddt = x->w.projected,
                          .dt_bias = x->small,
                          .a_log = x->small + x->w.scan_heads,
                          .d = x->small + 2 * x->w.scan_heads};
}
static void scan(Bench *x) {
    const FfpScanShape shape = scan_shape(x);
    const FfpScanInput in = scan_input(x);
    ffp_scan_forward(x->c, &shape, &in, x->scratch);
}
static void scan_back(Bench *x) {
    const FfpScanShape shape = scan_shape(x);
    const FfpScanInput in = scan_input(x);
    const FfpScanGradient grad = {.x = x->d,
                                  .b = x->d + x->w.inner,
                                  .c = x->d + x->w.inner + x->w.state,
                                  .dt_raw = x->dweight,
                                  .dt_bias = x->dsmall,
                                  .a_log = x->dsmall + x->w.scan_heads,
                                  .d = x->dsmall + 2 * x->w.scan_heads};
    ffp_scan_backward(&grad, &shape, &in, x->b, x->scratch);
}
static FfpDepthwise conv_input(const Bench *x) {
    return (FfpDepthwise){.x = x->a,
                          .w = x->weight,
                          .bias = x->small,
                          .ldx = x->w.projected,
                          .rows = x->rows,
                          .channels = x->w.convolved,
                          .taps = FFP_CONV_TAPS};
}
static void conv(Bench *x) {
    const FfpDepthwise in = conv_input(x);
    ffp_conv_forward(x->c, &in);
}
static void conv_back(Bench *x) {
    const FfpDepthwise in = conv_input(x);
    const FfpDepthwiseGradient grad = {.x = x->d, .w = x->dweight, .bias = x->dsmall, .ldx = x->w.projected};
    ffp_conv_backward(&grad, &in, x->b);
}
static void gelu(Bench *x) {
    ffp_gelu_forward(x->c, x->a, (size_t)x->rows * FFP_MLP_RATIO * x->w.dim);
}
static void gelu_back(Bench *x) {
    ffp_gelu_backward(x->c, x->b, x->a, (size_t)x->rows * FFP_MLP_RATIO * x->w.dim);
}
static void add(Bench *x) {
    ffp_add(x->c, x->a, (size_t)x->rows * x->w.inner);
}
static void layernorm(Bench *x) {
    ffp_layernorm_forward(x->c, x->row, x->row2, x->a, x->small, x->rows, x->w.dim);
}
static void layernorm_back(Bench *x) {
    ffp_layernorm_backward(x->c, x->dsmall, x->b, x->a, x->row, x->row2, x->small, x->rows, x->w.dim);
}
static FfpGatedNorm gated_input(const Bench *x) {
    return (FfpGatedNorm){
        .x = x->a, .z = x->b, .ldz = x->w.projected, .gain = x->small, .rows = x->rows, .dim = x->w.inner};
}
static void gated(Bench *x) {
    const FfpGatedNorm in = gated_input(x);
    ffp_gated_norm_forward(x->c, x->row2, &in);
}
static void gated_back(Bench *x) {
    const FfpGatedNorm in = gated_input(x);
    const FfpGatedNormGradient grad = {.x = x->c, .z = x->d, .ldz = x->w.projected, .gain = x->dsmall};
    ffp_gated_norm_backward(&grad, &in, x->b, x->row2);
}

static void *numbers(FfpRng *rng, size_t count, float spread, float centre) {
    float *x = ffp_alloc(count, sizeof *x);
    for (size_t i = 0; i < count; i++) x[i] = centre + spread * ffp_rng_range(rng, -1, 1);
    float *there = ffp_memory_uploaded(x, count, sizeof *x);
    ffp_free(x);
    return there;
}

// Operations, if it is a product, otherwise bytes that must be read and written; a line of the table.
static void report(Bench *data, const char *name, void (*run)(Bench *), bool product, double work) {
    const double time = seconds(run, data), rate = work / time;
    printf("%-8s %-20s %9.4f ms %9.1f %s %5.1f %%\n", data->name, name, 1e3 * time,
           rate / (product ? 1e12 : 1e9), product ? "TFLOP/s" : "GB/s   ",
           100 * rate / (product ? product_peak : copy_peak));
}

static void report_all(Bench *x) {
    const double rows = x->rows, dim = x->w.dim, inner = x->w.inner, wide = FFP_MLP_RATIO * dim,
                 state = x->w.state;
    const double pairs = 2 * rows * rows * dim, states = 2 * rows * inner * state,
                 squares = 2 * rows * x->w.chunk * (inner + state);
    report(x, "in_proj", in_proj, true, 2 * rows * dim * x->w.projected);
    report(x, "in_proj back", in_proj_back, true, 4 * rows * dim * x->w.projected);
    report(x, "out_proj + residual", out_proj, true, 2 * rows * dim * inner);
    report(x, "out_proj back", out_proj_back, true, 4 * rows * dim * inner);
    report(x, "fc1", fc1, true, 2 * rows * dim * wide);
    report(x, "fc1 back", fc1_back, true, 4 * rows * dim * wide);
    report(x, "gemm, fp32", gemm, true, 2 * rows * dim * wide);
    report(x, "dw, dbias of 8", bias_back, false, 4 * rows * wide);
    report(x, "attention", attention, true, 2 * pairs);
    report(x, "attention back", attention_back, true, 5 * pairs);
    report(x, "scan", scan, true, 2 * states + squares);
    report(x, "scan back", scan_back, true, 5 * states + 2 * squares);
    report(x, "conv", conv, false, 8 * rows * x->w.convolved);
    report(x, "conv back", conv_back, false, 16 * rows * x->w.convolved);
    report(x, "gelu", gelu, false, 8 * rows * wide);
    report(x, "gelu back", gelu_back, false, 12 * rows * wide);
    report(x, "add", add, false, 12 * rows * inner);
    report(x, "layernorm", layernorm, false, 8 * rows * dim);
    report(x, "layernorm back", layernorm_back, false, 12 * rows * dim);
    report(x, "gated norm", gated, false, 12 * rows * inner);
    report(x, "gated norm back", gated_back, false, 24 * rows * inner);
}

static size_t greater(size_t a, size_t b) {
    return a > b ? a : b;
}

static void bench(const char *name, int rows, int dim, int state) {
    FfpModelConfig config;
    FfpRng rng = ffp_rng(1, 0);
    ffp_model_preset(&config, "small");
    config.dim = dim;
    config.state = state;
    Bench x = {.name = name, .rows = rows, .w = ffp_widths(&config)};
    const FfpScanShape shape = scan_shape(&x);
    const FfpAttentionShape heads = attention_shape(&x);
    x.most = greater((size_t)rows, (size_t)dim) * greater((size_t)x.w.projected, FFP_MLP_RATIO * (size_t)dim);
    x.a = numbers(&rng, x.most, 1, 0);
    x.b = numbers(&rng, x.most, 1, 0);
    x.c = numbers(&rng, x.most, 1, 0);
    x.d = numbers(&rng, x.most, 1, 0);
    x.weight = numbers(&rng, x.most, 0.1F, 0);
    x.dweight = numbers(&rng, x.most, 1, 0);
    x.small = numbers(&rng, 16384, 0.1F, 1);
    x.dsmall = numbers(&rng, 16384, 0, 0);
    x.row = numbers(&rng, (size_t)rows * 64, 1, 0);
    x.row2 = numbers(&rng, (size_t)rows * 64, 0, 1);
    const size_t scratch = greater(ffp_scan_scratch(&shape), ffp_attention_scratch(&heads));
    x.scratch = ffp_memory_new(scratch, sizeof(float));
    printf("%s: %d tokens of width %d, state %d; scratch %.0f MB\n", name, rows, dim, state,
           (double)scratch * 4e-6);
    report_all(&x);
    float *all[] = {x.a, x.b, x.c, x.d, x.weight, x.dweight, x.small, x.dsmall, x.row, x.row2, x.scratch};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) ffp_memory_free(all[i]);
}

static void large_product(Bench *x) {
    const FfpCudaProduct product = {.operands = FFP_OPERANDS_BF16,
                                    .transpose_b = true,
                                    .m = x->rows,
                                    .n = x->rows,
                                    .k = x->rows,
                                    .alpha = 1,
                                    .a = x->a,
                                    .lda = x->rows,
                                    .b = x->b,
                                    .ldb = x->rows,
                                    .c = x->c,
                                    .ldc = x->rows,
                                    .count = 1};
    ffp_cuda_product(&product);
}

static void large_copy(Bench *x) {
    ffp_device()->copy(x->c, x->d, x->most * sizeof(float));
}

// Random numbers as bf16, [side, side] of them.
static float *halves(FfpRng *rng, size_t side) {
    uint16_t *x = ffp_alloc(side * side, sizeof *x);
    for (size_t i = 0; i < side * side; i++) { // 0.5 to 1, either sign
        const uint32_t bits = ffp_rng_u32(rng);
        x[i] = (uint16_t)(0x3f00U | (bits & 0x807fU));
    }
    float *there = ffp_memory_uploaded(x, side * side, sizeof *x);
    ffp_free(x);
    return there;
}

static void measure_peaks(void) {
    FfpRng rng = ffp_rng(2, 0);
    const size_t side = gpu_emulated() ? 64 : 8192, count = side * side;
    Bench x = {.rows = (int)side, .most = count, .a = halves(&rng, side), .b = halves(&rng, side)};
    x.c = ffp_memory_new(count, sizeof(float));
    x.d = numbers(&rng, count, 1, 0);
    product_peak = 2.0 * (double)count * (double)side / seconds(large_product, &x);
    copy_peak = 8.0 * (double)count / seconds(large_copy, &x);
    printf("%s\nproduct of %zu^3 in bf16: %.0f TFLOP/s; copy of %.0f MB: %.0f GB/s read and written\n",
           ffp_cuda_describe(), side, product_peak * 1e-12, (double)count * 4e-6, copy_peak * 1e-9);
    ffp_memory_free(x.a);
    ffp_memory_free(x.b);
    ffp_memory_free(x.c);
    ffp_memory_free(x.d);
}

int main(void) {
    if (!gpu_open()) return 1;
    measure_peaks();
    if (gpu_emulated()) {
        bench("tiny", 70, 64, 16);
        return 0;
    }
    bench("small", 2048, 384, 64);
    bench("paper", 2048, 1024, 64);
    bench("paper128", 2048, 1024, 128);
    return 0;
}
