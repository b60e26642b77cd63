// Times every kernel, forward and backward, at the sizes the network has.
#ifndef FFP_TESTS_TENSOR_BENCH_KERNELS_H
#define FFP_TESTS_TENSOR_BENCH_KERNELS_H

#include <omp.h>
#include <stdio.h>
#include "base/cpu.h"
#include "base/alloc.h"
#include "tensor/random.h"
#include "tensor/tensor.h"

enum {
    BENCH_ROWS = 2048,
    BENCH_STATE = 64,
    BENCH_CHUNK = 64,
    BENCH_TAPS = 4,
    BENCH_MOST = BENCH_ROWS * 2048
};

// Arrays large enough for every kernel at the largest size.
typedef struct Bench {
    float *a, *b, *c, *d, *w, *dw, *small, *dsmall, *row, *row2, *scratch;
    int dim, heads; // model width, heads of 64
} Bench;

typedef void (*BenchRun)(Bench *bench);

static int bench_inner(const Bench *b) {
    return 2 * b->dim;
}
static int bench_channels(const Bench *b) {
    return bench_inner(b) + 2 * BENCH_STATE;
}

static void bench_linear_forward(Bench *b) {
    ffp_linear_forward(b->c, b->a, b->w, NULL, BENCH_ROWS, b->dim, 4 * b->dim);
}
static void bench_linear_backward(Bench *b) {
    ffp_linear_backward(b->c, b->dw, NULL, b->b, b->a, b->w, BENCH_ROWS, b->dim, 4 * b->dim);
}
static void bench_layernorm_forward(Bench *b) {
    ffp_layernorm_forward(b->c, b->row, b->row2, b->a, b->small, BENCH_ROWS, b->dim);
}
static void bench_layernorm_backward(Bench *b) {
    ffp_layernorm_backward(b->c, b->dsmall, b->b, b->a, b->row, b->row2, b->small, BENCH_ROWS, b->dim);
}
static void bench_rmsnorm_forward(Bench *b) {
    ffp_rmsnorm_forward(b->c, b->row2, b->a, b->small, BENCH_ROWS, b->dim);
}
static void bench_rmsnorm_backward(Bench *b) {
    ffp_rmsnorm_backward(b->c, b->dsmall, b->b, b->a, b->row2, b->small, BENCH_ROWS, b->dim);
}
static void bench_gated_forward(Bench *b) {
    ffp_gated_norm_forward(b->c, b->row2, b->a, b->b, bench_inner(b), b->small, BENCH_ROWS, bench_inner(b));
}
static void bench_gated_backward(Bench *b) {
    ffp_gated_norm_backward(b->c, b->d, bench_inner(b), b->dsmall, b->b, b->a, b->b, bench_inner(b), b->row2,
                            b->small, BENCH_ROWS, bench_inner(b));
}
static void bench_gelu_forward(Bench *b) {
    ffp_gelu_forward(b->c, b->a, (size_t)BENCH_ROWS * 4 * (size_t)b->dim);
}
static void bench_gelu_backward(Bench *b) {
    ffp_gelu_backward(b->c, b->b, b->a, (size_t)BENCH_ROWS * 4 * (size_t)b->dim);
}
static void bench_conv_forward(Bench *b) {
    const int channels = bench_channels(b);
    ffp_conv_forward(b->c, b->a, channels, b->w, b->small, BENCH_ROWS, channels, BENCH_TAPS, false);
}
static void bench_conv_backward(Bench *b) {
    const int channels = bench_channels(b);
    ffp_conv_backward(b->d, channels, b->dw, b->dsmall, b->b, b->a, channels, b->w, b->small, BENCH_ROWS,
                      channels, BENCH_TAPS, false);
}

static FfpScanShape bench_scan_shape(const Bench *b) {
    return (FfpScanShape){.rows = BENCH_ROWS,
                          .heads = bench_inner(b) / 64,
                          .head_dim = 64,
                          .state = BENCH_STATE,
                          .chunk = BENCH_CHUNK};
}
static FfpScanInput bench_scan_input(const Bench *b) {
    const int inner = bench_inner(b), heads = inner / 64;
    return (FfpScanInput){b->a,  b->a + inner, b->a + inner + BENCH_STATE, bench_channels(b),   b->b,
                          heads, b->small,     b->small + heads,           b->small + 2 * heads};
}
static void bench_scan_forward(Bench *b) {
    const FfpScanShape shape = bench_scan_shape(b);
    const FfpScanInput in = bench_scan_input(b);
    ffp_scan_forward(b->c, &shape, &in, b->scratch);
}
static void bench_scan_backward(Bench *b) {
    const FfpScanShape shape = bench_scan_shape(b);
    const FfpScanInput in = bench_scan_input(b);
    const int inner = bench_inner(b);
    const FfpScanGradient grad = {
        b->d, b->d + inner, b->d + inner + BENCH_STATE, b->row, b->dsmall, b->dsmall + 64, b->dsmall + 128};
    ffp_scan_backward(&grad, &shape, &in, b->b, b->scratch);
}
static void bench_attention_forward(Bench *b) {
    ffp_attention_forward(b->c, b->row, b->a, b->small, b->small, BENCH_ROWS, b->heads, 64, b->scratch);
}
static void bench_attention_backward(Bench *b) {
    ffp_attention_backward(b->d, b->dsmall, b->dsmall + 64, b->b, b->c, b->row, b->a, b->small, b->small,
                           BENCH_ROWS, b->heads, 64, b->scratch);
}

// The best of the runs that fit a second, after one to warm up. gigabytes: arrays read and written once each.
static void bench_kernel(Bench *b, const char *name, BenchRun run, double gflop, double gigabytes) {
    double best = 1e9;
    run(b);
    for (double start = omp_get_wtime(); omp_get_wtime() - start < 1;) {
        const double begin = omp_get_wtime();
        run(b);
        const double took = omp_get_wtime() - begin;
        if (took < best) best = took;
    }
    printf("%-20s dim %d  %8.3f ms  %7.1f GFLOP/s  %6.1f GB/s\n", name, b->dim, best * 1e3, gflop / best,
           gigabytes / best);
}

// Operations: a multiply-add is two; an exponential, a division or a square root counts as one.
static void bench_size(Bench *b) {
    const double rows = BENCH_ROWS * 1e-9, dim = b->dim, inner = 2 * dim, channels = inner + 2 * BENCH_STATE;
    const double linear = 2 * rows * dim * 4 * dim, pairs = 2 * rows * BENCH_ROWS * dim, word = 4 * rows;
    const double state = 2 * rows * inner * BENCH_STATE, square = 2 * rows * inner * BENCH_CHUNK;
    bench_kernel(b, "linear_forward", bench_linear_forward, linear, word * 5 * dim);
    bench_kernel(b, "linear_backward", bench_linear_backward, 2 * linear, word * 10 * dim);
    bench_kernel(b, "layernorm_forward", bench_layernorm_forward, 8 * rows * dim, word * 2 * dim);
    bench_kernel(b, "layernorm_backward", bench_layernorm_backward, 16 * rows * dim, word * 3 * dim);
    bench_kernel(b, "rmsnorm_forward", bench_rmsnorm_forward, 4 * rows * dim, word * 2 * dim);
    bench_kernel(b, "rmsnorm_backward", bench_rmsnorm_backward, 12 * rows * dim, word * 3 * dim);
    bench_kernel(b, "gated_norm_forward", bench_gated_forward, 9 * rows * inner, word * 3 * inner);
    bench_kernel(b, "gated_norm_backward", bench_gated_backward, 25 * rows * inner, word * 6 * inner);
    bench_kernel(b, "gelu_forward", bench_gelu_forward, 20 * rows * 4 * dim, word * 8 * dim);
    bench_kernel(b, "gelu_backward", bench_gelu_backward, 24 * rows * 4 * dim, word * 12 * dim);
    bench_kernel(b, "conv_forward", bench_conv_forward, 12 * rows * channels, word * 2 * channels);
    bench_kernel(b, "conv_backward", bench_conv_backward, 33 * rows * channels, word * 4 * channels);
    bench_kernel(b, "scan_forward", bench_scan_forward, 2 * state + square, word * (inner + channels));
    bench_kernel(b, "scan_backward", bench_scan_backward, 5 * state + 2 * square,
                 word * 2 * (inner + channels));
    bench_kernel(b, "attention_forward", bench_attention_forward, 2 * pairs, word * 4 * dim);
    bench_kernel(b, "attention_backward", bench_attention_backward, 5 * pairs, word * 8 * dim);
}

// Operations a second in units of 1e9, of all threads together: the best of some repeats.
static double bench_peak(void) {
    double best = 0;
    for (int repeat = 0; repeat < 40; repeat++) {
        double operations = 0;
        const double begin = omp_get_wtime();
#pragma omp parallel reduction(+ : operations)
        operations += ffp_multiply_registers(32);
        const double rate = operations * 1e-9 / (omp_get_wtime() - begin);
        if (rate > best) best = rate;
    }
    return best;
}

// The three products of a linear layer: forward, to the input's gradient, to the weights'.
static void run_product(const Bench *b, int form, int in, int out) {
    const int rows = BENCH_ROWS;
    if (form == 0) ffp_gemm_mixed(false, true, rows, out, in, 1, b->a, in, b->w, in, 0, b->c, out);
    if (form == 1) ffp_gemm_mixed(false, false, rows, in, out, 1, b->b, out, b->w, in, 0, b->c, in);
    if (form == 2) ffp_gemm_mixed(true, false, out, in, rows, 1, b->b, out, b->a, in, 1, b->dw, in);
}

static double bench_product(const Bench *b, int form, int in, int out) {
    double best = 1e9;
    for (int repeat = 0; repeat < 30; repeat++) {
        const double begin = omp_get_wtime();
        run_product(b, form, in, out);
        const double took = omp_get_wtime() - begin;
        if (took < best) best = took;
    }
    return 2e-9 * BENCH_ROWS * in * out / best;
}

static void bench_products(const Bench *b) {
    const int in[] = {384, 256}, out[] = {1536, 1024};
    const FfpCpuLevel used = ffp_cpu_level();
    for (int level = 0; level <= (int)ffp_cpu_best(); level++) {
        ffp_cpu_set_level((FfpCpuLevel)level);
        const double peak = bench_peak();
        for (int size = 0; size < 2; size++) {
            printf("%-11s peak %6.1f GFLOP/s  %dx%dx%d", ffp_cpu_name((FfpCpuLevel)level), peak, BENCH_ROWS,
                   in[size], out[size]);
            for (int form = 0; form < 3; form++) {
                const double rate = bench_product(b, form, in[size], out[size]);
                printf("  %s %6.1f (%.0f %%)", (const char *[]){"y", "dx", "dw"}[form], rate,
                       100 * rate / peak);
            }
            printf("\n");
        }
    }
    ffp_cpu_set_level(used);
}

static int bench_kernels(void) {
    FfpRng rng = ffp_rng(1, 0);
    Bench b = {random_reals(&rng, BENCH_MOST, 0.5, 0),
               random_reals(&rng, BENCH_MOST, 0.5, 0),
               random_reals(&rng, BENCH_MOST, 1, 0),
               random_reals(&rng, BENCH_MOST, 1, 0),
               random_reals(&rng, BENCH_MOST, 0.1, 0),
               random_reals(&rng, BENCH_MOST, 1, 0),
               random_reals(&rng, 4096, 0.1, 1),
               random_reals(&rng, 4096, 0, 0),
               random_reals(&rng, BENCH_ROWS * 16, 1, 0),
               random_reals(&rng, BENCH_ROWS, 1, 0),
               NULL,
               384,
               6};
    const FfpScanShape shape = bench_scan_shape(&b);
    const size_t scan = ffp_scan_scratch(&shape), attention = ffp_attention_scratch(BENCH_ROWS, b.heads, 64);
    b.scratch = ffp_alloc(scan > attention ? scan : attention, sizeof(float));
    printf("%d rows, %d threads\n", BENCH_ROWS, omp_get_max_threads());
    bench_products(&b);
    bench_size(&b);
    b.dim = 256, b.heads = 4;
    bench_size(&b);
    float *all[] = {b.a, b.b, b.c, b.d, b.w, b.dw, b.small, b.dsmall, b.row, b.row2, b.scratch};
    for (size_t i = 0; i < sizeof(all) / sizeof(all[0]); i++) ffp_free(all[i]);
    return 0;
}

#endif
