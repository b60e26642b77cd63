// The tensor room's kernels at the sizes of `small`, and the products of one larger layer.
#include "core/tensor/tensor.h"
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include "core/base/arena.h"
#include "core/base/rng.h"
#include "lab/bench/bench.h"

enum {
    ROWS = 2048,
    COUNTED_ROWS = 256,
    DIM = 256,
    HEADS = 4,
    HEAD_DIM = 64,
    STATE = 64,
    CHUNK = 64,
    TAPS = 4
};
enum { INNER = 2 * DIM, SCAN_HEADS = INNER / HEAD_DIM, CHANNELS = INNER + 2 * STATE, WIDE = 4 * DIM };
enum { LARGE_IN = 384, LARGE_OUT = 1536, MOST = ROWS * LARGE_OUT };

// Arrays that are large enough for every kernel.
typedef struct Data {
    int rows; // tokens: fewer where instructions are counted, which an emulator executes
    FfpScanShape scan;
    FfpAttentionShape attention;
    float *a, *b, *c, *d, *w, *dw;                // [MOST]
    float *small, *dsmall, *row, *row2, *scratch; // [4096], [4096], [ROWS * 16], [ROWS * 16]
    float *a_log; // [SCAN_HEADS] of states that outlast a chunk, as those of networks do: none is denormal
} Data;

static void gemm(void *data) {
    const Data *x = data;
    ffp_linear_forward(x->c, x->a, x->w, NULL, x->rows, LARGE_IN, LARGE_OUT);
}
static void gemm_dx(void *data) {
    const Data *x = data;
    ffp_gemm_mixed(1, ffp_factor(x->b, x->rows, LARGE_OUT, LARGE_OUT),
                   ffp_factor(x->w, LARGE_OUT, LARGE_IN, LARGE_IN), 0, x->c, LARGE_IN);
}
static void gemm_dw(void *data) {
    const Data *x = data;
    ffp_gemm_mixed(1, ffp_transposed(ffp_factor(x->b, x->rows, LARGE_OUT, LARGE_OUT)),
                   ffp_factor(x->a, x->rows, LARGE_IN, LARGE_IN), 1, x->dw, LARGE_IN);
}
static void linear_forward(void *data) {
    const Data *x = data;
    ffp_linear_forward(x->c, x->a, x->w, NULL, x->rows, DIM, WIDE);
}
static void linear_backward(void *data) {
    const Data *x = data;
    ffp_linear_backward(x->c, x->dw, NULL, x->b, x->a, x->w, x->rows, DIM, WIDE);
}
static void attention_forward(void *data) {
    const Data *x = data;
    const FfpAttentionInput in = {x->a, x->small, x->small};
    ffp_attention_forward(x->c, x->row, &x->attention, &in, x->scratch);
}
static void attention_backward(void *data) {
    const Data *x = data;
    const FfpAttentionInput in = {x->a, x->small, x->small};
    const FfpAttentionGradient grad = {x->d, x->dsmall, x->dsmall + HEAD_DIM};
    ffp_attention_backward(&grad, &x->attention, &in, x->c, x->row, x->b, x->scratch);
}
static FfpScanInput scan_input(const Data *x) {
    return (FfpScanInput){.x = x->a,
                          .b = x->a + INNER,
                          .c = x->a + INNER + STATE,
                          .ld = CHANNELS,
                          .dt_raw = x->b,
                          .lddt = SCAN_HEADS,
                          .dt_bias = x->small,
                          .a_log = x->a_log,
                          .d = x->small + 2 * SCAN_HEADS};
}
static void scan_forward(void *data) {
    const Data *x = data;
    const FfpScanInput in = scan_input(x);
    ffp_scan_forward(x->c, &x->scan, &in, x->scratch);
}
static void scan_backward(void *data) {
    const Data *x = data;
    const FfpScanInput in = scan_input(x);
    const FfpScanGradient grad = {.x = x->d,
                                  .b = x->d + INNER,
                                  .c = x->d + INNER + STATE,
                                  .dt_raw = x->row,
                                  .dt_bias = x->dsmall,
                                  .a_log = x->dsmall + SCAN_HEADS,
                                  .d = x->dsmall + 2 * SCAN_HEADS};
    ffp_scan_backward(&grad, &x->scan, &in, x->b, x->scratch);
}
static FfpDepthwise conv_input(const Data *x) {
    return (FfpDepthwise){.x = x->a,
                          .w = x->w,
                          .bias = x->small,
                          .ldx = CHANNELS,
                          .rows = x->rows,
                          .channels = CHANNELS,
                          .taps = TAPS};
}
static void conv_forward(void *data) {
    const Data *x = data;
    const FfpDepthwise conv = conv_input(x);
    ffp_conv_forward(x->c, &conv);
}
static void conv_backward(void *data) {
    const Data *x = data;
    const FfpDepthwise conv = conv_input(x);
    const FfpDepthwiseGradient grad = {.x = x->d, .w = x->dw, .bias = x->dsmall, .ldx = CHANNELS};
    ffp_conv_backward(&grad, &conv, x->b);
}
static void gelu_forward(void *data) {
    const Data *x = data;
    ffp_gelu_forward(x->c, x->a, (size_t)x->rows * WIDE);
}
static void gelu_backward(void *data) {
    const Data *x = data;
    ffp_gelu_backward(x->c, x->b, x->a, (size_t)x->rows * WIDE);
}
static void layernorm_forward(void *data) {
    const Data *x = data;
    ffp_layernorm_forward(x->c, x->row, x->row2, x->a, x->small, x->rows, DIM);
}
static void layernorm_backward(void *data) {
    const Data *x = data;
    ffp_layernorm_backward(x->c, x->dsmall, x->b, x->a, x->row, x->row2, x->small, x->rows, DIM);
}
static FfpGatedNorm gated_norm_input(const Data *x) {
    return (FfpGatedNorm){
        .x = x->a, .z = x->b, .ldz = INNER, .gain = x->small, .rows = x->rows, .dim = INNER};
}
static void gated_norm_forward(void *data) {
    const Data *x = data;
    const FfpGatedNorm in = gated_norm_input(x);
    ffp_gated_norm_forward(x->c, x->row2, &in);
}
static void gated_norm_backward(void *data) {
    const Data *x = data;
    const FfpGatedNorm in = gated_norm_input(x);
    const FfpGatedNormGradient grad = {.x = x->c, .z = x->d, .ldz = INNER, .gain = x->dsmall};
    ffp_gated_norm_backward(&grad, &in, x->b, x->row2);
}

// Work of products in operations; of everything else in bytes read and written once.
#define LARGE (2.0 * ROWS * LARGE_IN * LARGE_OUT)
#define PAIRS (2.0 * ROWS * ROWS * DIM)
#define LINEAR (2.0 * ROWS * DIM * WIDE)
#define SCAN_STATE (2.0 * ROWS * INNER * STATE)
#define SCAN_SQUARE (2.0 * ROWS * CHUNK * (INNER + STATE))
static const struct {
    const char *name, *before, *after; // of the rows in the shape
    void (*run)(void *);
    FfpBound bound;
    double work;
} cases[] = {
    {"gemm", "", "x384x1536, y = x w^T", gemm, FFP_BOUND_PRODUCTS, LARGE},
    {"gemm_dx", "", "x1536x384, dx = dy w", gemm_dx, FFP_BOUND_PRODUCTS, LARGE},
    {"gemm_dw", "1536x", "x384, dw += dy^T x", gemm_dw, FFP_BOUND_PRODUCTS, LARGE},
    {"linear_forward", "", "x256x1024", linear_forward, FFP_BOUND_PRODUCTS, LINEAR},
    {"linear_backward", "", "x256x1024", linear_backward, FFP_BOUND_PRODUCTS, 2 * LINEAR},
    {"attention_forward", "", " tokens, 4 heads of 64", attention_forward, FFP_BOUND_PRODUCTS, 2 * PAIRS},
    {"attention_backward", "", " tokens, 4 heads of 64", attention_backward, FFP_BOUND_PRODUCTS, 5 * PAIRS},
    {"scan_forward", "", " tokens, 8 heads of 64, state 64", scan_forward, FFP_BOUND_PRODUCTS,
     2 * SCAN_STATE + SCAN_SQUARE},
    {"scan_backward", "", " tokens, 8 heads of 64, state 64", scan_backward, FFP_BOUND_PRODUCTS,
     5 * SCAN_STATE + 2 * SCAN_SQUARE},
    {"conv_forward", "", "x640, 4 taps", conv_forward, FFP_BOUND_COPY, 8.0 * ROWS *CHANNELS},
    {"conv_backward", "", "x640, 4 taps", conv_backward, FFP_BOUND_COPY, 16.0 * ROWS *CHANNELS},
    {"gelu_forward", "", "x1024", gelu_forward, FFP_BOUND_COPY, 8.0 * ROWS *WIDE},
    {"gelu_backward", "", "x1024", gelu_backward, FFP_BOUND_COPY, 12.0 * ROWS *WIDE},
    {"layernorm_forward", "", "x256", layernorm_forward, FFP_BOUND_COPY, 8.0 * ROWS *DIM},
    {"layernorm_backward", "", "x256", layernorm_backward, FFP_BOUND_COPY, 12.0 * ROWS *DIM},
    {"gated_norm_forward", "", "x512", gated_norm_forward, FFP_BOUND_COPY, 12.0 * ROWS *INNER},
    {"gated_norm_backward", "", "x512", gated_norm_backward, FFP_BOUND_COPY, 24.0 * ROWS *INNER},
};

static float *numbers(FfpRng *rng, size_t count, float spread, float centre) {
    float *x = ffp_alloc(count, sizeof *x);
    for (size_t i = 0; i < count; i++) x[i] = centre + spread * ffp_rng_range(rng, -1, 1);
    return x;
}

void ffp_bench_kernels(FfpBenchTable *table) {
    FfpRng rng = ffp_rng(1, 0);
    const int rows = ffp_bench_clock.exact ? COUNTED_ROWS : ROWS;
    const FfpScanShape scan = {
        .rows = rows, .heads = SCAN_HEADS, .head_dim = HEAD_DIM, .state = STATE, .chunk = CHUNK};
    const FfpAttentionShape attention = {.rows = rows, .heads = HEADS, .head_dim = HEAD_DIM};
    const size_t scratch[2] = {ffp_scan_scratch(&scan), ffp_attention_scratch(&attention)};
    Data x = {.rows = rows,
              .scan = scan,
              .attention = attention,
              .a = numbers(&rng, MOST, 1, 0),
              .b = numbers(&rng, MOST, 1, 0),
              .c = numbers(&rng, MOST, 1, 0),
              .d = numbers(&rng, MOST, 1, 0),
              .w = numbers(&rng, MOST, 0.1F, 0),
              .dw = numbers(&rng, MOST, 1, 0),
              .small = numbers(&rng, 4096, 0.1F, 1),
              .dsmall = numbers(&rng, 4096, 0, 0),
              .row = numbers(&rng, (size_t)ROWS * 16, 1, 0),
              .row2 = numbers(&rng, (size_t)ROWS * 16, 0, 1),
              .a_log = numbers(&rng, SCAN_HEADS, 0.1F, -4),
              .scratch = ffp_alloc(scratch[0] > scratch[1] ? scratch[0] : scratch[1], sizeof(float))};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        FfpBenchRow row = {
            .name = cases[i].name, .bound = cases[i].bound, .work = rows == ROWS ? cases[i].work : 0};
        snprintf(row.shape, sizeof row.shape, "%s%d%s", cases[i].before, rows, cases[i].after);
        row.ms = ffp_bench_time(cases[i].run, &x, 5, 0.3);
        ffp_bench_add(table, &row);
    }
    float *all[] = {x.a, x.b, x.c, x.d, x.w, x.dw, x.small, x.dsmall, x.row, x.row2, x.scratch, x.a_log};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) ffp_free(all[i]);
}
