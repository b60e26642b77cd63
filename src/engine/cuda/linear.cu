// Products of matrices and linear layers.
#include "engine/cuda/launch.h"
extern "C" {
#include "engine/cuda/tensor.h"
}
#include "engine/cuda/bf16.h"
#include "engine/cuda/columns.h"
#include "engine/cuda/memory.h"
#include "engine/cuda/products.h"

enum { GROUP = 8, OPERANDS_MAX = 3 }; // numbers a thread rounds: 16 bytes

// A factor as it is stored, and its place as bf16. Rows and columns there are whole groups, filled up with
// zeros: so they begin at multiples of 16 bytes, and a product may run over k rounded up.
typedef struct Operand {
    const float *from;
    int ld, rows, columns;
    bool transposed; // the product reads it so
    bool aligned;    // its rows begin at multiples of 16 bytes
    uint16_t *to;
    int to_ld;
    size_t groups;
} Operand;

typedef struct Operands {
    Operand of[OPERANDS_MAX];
    int count;
    size_t groups;
} Operands;

static int whole_groups(int count) {
    return (count + GROUP - 1) / GROUP * GROUP;
}

static Operand operand(FfpFactor factor) {
    const FfpFactor stored = factor.transposed ? ffp_transposed(factor) : factor;
    const int to_ld = whole_groups(stored.columns);
    return (Operand){.from = stored.data,
                     .ld = stored.stride,
                     .rows = stored.rows,
                     .columns = stored.columns,
                     .transposed = factor.transposed,
                     .aligned = stored.stride % 4 == 0 && (uintptr_t)stored.data % 16 == 0,
                     .to = NULL,
                     .to_ld = to_ld,
                     .groups = (size_t)whole_groups(stored.rows) * (size_t)(to_ld / GROUP)};
}

static Operand transposed(Operand o) {
    o.transposed = !o.transposed;
    return o;
}

static __device__ void load_group(float out[GROUP], const Operand *o, int row, int column) {
    const float *from = o->from + (size_t)row * o->ld + column;
    if (o->aligned && row < o->rows && column + GROUP <= o->columns) {
        const float4 low = *(const float4 *)from, high = *(const float4 *)(from + 4);
        out[0] = low.x, out[1] = low.y, out[2] = low.z, out[3] = low.w;
        out[4] = high.x, out[5] = high.y, out[6] = high.z, out[7] = high.w;
        return;
    }
    for (int i = 0; i < GROUP; i++) out[i] = row < o->rows && column + i < o->columns ? from[i] : 0;
}

// One thread for each group of all operands.
static __global__ void round_operands(size_t count, Operands operands) {
    size_t group = ffp_thread();
    if (group >= count) return;
    int which = 0;
    while (group >= operands.of[which].groups) group -= operands.of[which++].groups;
    const Operand *o = &operands.of[which];
    const int groups_a_row = o->to_ld / GROUP;
    float x[GROUP];
    load_group(x, o, (int)(group / groups_a_row), (int)(group % groups_a_row) * GROUP);
    uint4 rounded;
    rounded.x = ffp_bf16_pair(x[0], x[1]), rounded.y = ffp_bf16_pair(x[2], x[3]);
    rounded.z = ffp_bf16_pair(x[4], x[5]), rounded.w = ffp_bf16_pair(x[6], x[7]);
    ((uint4 *)o->to)[group] = rounded;
}

// Rounds all operands in one launch, into memory that is good until the next call.
static void round_all(Operands *operands) {
    static void *block;
    static size_t capacity;
    operands->groups = 0;
    for (int i = 0; i < operands->count; i++) operands->groups += operands->of[i].groups;
    ffp_cuda_grow(&block, &capacity, operands->groups * sizeof(uint4));
    uint16_t *next = (uint16_t *)block;
    for (int i = 0; i < operands->count; i++) {
        operands->of[i].to = next;
        next += operands->of[i].groups * GROUP;
    }
    ffp_launch_each(operands->groups, round_operands, *operands);
}

// C = alpha A B + beta C of two rounded operands
static void multiply(float alpha, Operand a, Operand b, float beta, float *c, int ldc) {
    const FfpCudaProduct product = {.operands = FFP_OPERANDS_BF16,
                                    .m = a.transposed ? a.columns : a.rows,
                                    .n = b.transposed ? b.rows : b.columns,
                                    .k = whole_groups(a.transposed ? a.rows : a.columns),
                                    .alpha = alpha,
                                    .a = {a.to, a.to_ld, a.transposed},
                                    .b = {b.to, b.to_ld, b.transposed},
                                    .beta = beta,
                                    .c = c,
                                    .ldc = ldc};
    ffp_cuda_product(&product);
}

void ffp_cuda_gemm(float alpha, FfpFactor a, FfpFactor b, float beta, float *c, int ldc) {
    ffp_cuda_multiply(FFP_OPERANDS_F32, alpha, a, b, beta, c, ldc);
}

void ffp_cuda_gemm_mixed(float alpha, FfpFactor a, FfpFactor b, float beta, float *c, int ldc) {
    if (a.rows <= 0 || b.columns <= 0) return;
    Operands o = {.of = {operand(a), operand(b)}, .count = 2, .groups = 0};
    round_all(&o);
    multiply(alpha, o.of[0], o.of[1], beta, c, ldc);
}

// y [rows, out] = bias in every row
static __global__ void spread_bias(size_t count, float *y, const float *bias, int out) {
    const size_t i = ffp_thread();
    if (i < count) y[i] = bias[i % out];
}

// y = x w^T + beta y
static void forward_product(float *y, const float *x, const float *w, int rows, int in, int out, float beta) {
    ffp_cuda_gemm_mixed(1, ffp_factor(x, rows, in, in), ffp_transposed(ffp_factor(w, out, in, in)), beta, y,
                        out);
}

void ffp_cuda_linear_forward(float *y, const float *x, const float *w, const float *bias, int rows, int in,
                             int out) {
    if (rows <= 0) return;
    if (bias) ffp_launch_each((size_t)rows * out, spread_bias, y, bias, out);
    forward_product(y, x, w, rows, in, out, bias ? 1.0f : 0.0f);
}

void ffp_cuda_linear_residual_forward(float *y, const float *residual, const float *x, const float *w,
                                      int rows, int in, int out) {
    if (rows <= 0) return;
    if (y != residual) ffp_cuda_copy(y, residual, (size_t)rows * out * sizeof *y);
    forward_product(y, x, w, rows, in, out, 1);
}

// dx = dy w, dw += dy^T x, dbias += column sums of dy
void ffp_cuda_linear_backward(float *dx, float *dw, float *dbias, const float *dy, const float *x,
                              const float *w, int rows, int in, int out) {
    if (rows <= 0) return;
    Operands o = {.of = {operand(ffp_factor(dy, rows, out, out)), operand(ffp_factor(x, rows, in, in)),
                         operand(ffp_factor(w, out, in, in))},
                  .count = dx ? 3 : 2,
                  .groups = 0};
    round_all(&o);
    if (dx) multiply(1, o.of[0], o.of[2], 0, dx, in);
    multiply(1, transposed(o.of[0]), o.of[1], 1, dw, in);
    if (dbias) ffp_cuda_add_column_sums(dbias, dy, rows, out);
}
