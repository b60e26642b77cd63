// Softmax attention with RMS QK-norm, forward.
#include "engine/cuda/attention.h"
#include "engine/cuda/bf16.h"
#include "engine/cuda/products.h"
#include "engine/cuda/warp.h"

enum { THREADS = 256, WARPS = THREADS / FFP_WARP };
#define EPSILON 1e-5f

size_t ffp_cuda_attention_bytes = (size_t)768 << 20;

static int whole_eights(int count) {
    return (count + 7) / 8 * 8;
}

static FfpAttentionPlan make_shape(const FfpAttentionShape *shape) {
    const int rows = shape->rows, heads = shape->heads, dim = shape->head_dim;
    if (dim > FFP_ATTENTION_DIM_MAX) {
        fprintf(stderr, "ffprocams: error: GPU: attention heads of %d, at most %d\n", dim,
                FFP_ATTENTION_DIM_MAX);
        abort();
    }
    FfpAttentionPlan plan = {};
    plan.rows = rows;
    plan.heads = heads;
    plan.dim = dim;
    plan.width = heads * dim;
    plan.pad = whole_eights(dim);
    plan.keys = whole_eights(rows);
    const size_t line = (size_t)plan.keys * 2 * (sizeof(float) + sizeof(uint16_t)),
                 most = ffp_cuda_attention_bytes / line;
    const size_t square = (size_t)(rows > 0 ? rows : 1);
    plan.group = most >= square ? (int)min(most / square, (size_t)heads) : 1;
    plan.span = (int)min(most > 8 ? most : (size_t)8, square);
    return plan;
}

// Sizes in reals, in the order of FfpAttentionPlan.
enum { HALVES = 6, WHOLES = 5, PARTS = HALVES + WHOLES };
static void part_sizes(size_t sizes[PARTS], const FfpAttentionPlan *p) {
    const size_t lines = (size_t)p->heads * p->rows, square = (size_t)p->group * p->span * p->keys;
    const size_t parts[PARTS] = {lines * p->pad / 2,
                                 lines * p->pad / 2,
                                 lines * p->pad / 2,
                                 lines * p->pad / 2,
                                 square / 2,
                                 square / 2,
                                 lines,
                                 lines * p->pad,
                                 lines * p->pad,
                                 square,
                                 square};
    for (int i = 0; i < PARTS; i++) sizes[i] = (parts[i] + 63) / 64 * 64;
}

size_t ffp_cuda_attention_scratch(const FfpAttentionShape *shape) {
    const FfpAttentionPlan plan = make_shape(shape);
    size_t sizes[PARTS], sum = 0;
    part_sizes(sizes, &plan);
    for (int i = 0; i < PARTS; i++) sum += sizes[i];
    return sum;
}

FfpAttentionPlan ffp_cuda_attention_plan(const FfpAttentionShape *shape, float *scratch) {
    FfpAttentionPlan plan = make_shape(shape);
    size_t sizes[PARTS];
    part_sizes(sizes, &plan);
    uint16_t **halves[HALVES] = {&plan.q, &plan.k, &plan.v, &plan.dout, &plan.weights, &plan.dweights};
    float **wholes[WHOLES] = {&plan.delta, &plan.dq, &plan.dk, &plan.scores, &plan.dscores};
    for (int i = 0; i < PARTS; i++) {
        if (i < HALVES)
            *halves[i] = (uint16_t *)scratch;
        else
            *wholes[i - HALVES] = scratch;
        scratch += sizes[i];
    }
    return plan;
}

// Writes a row as bf16, zeros behind it. x holds each lane's numbers, FFP_WARP apart.
static __device__ void write_row(uint16_t *to, const float x[FFP_ATTENTION_EACH],
                                 const FfpAttentionPlan *plan) {
#pragma unroll
    for (int e = 0; e < FFP_ATTENTION_EACH; e++) {
        const int d = ffp_lane() + e * FFP_WARP;
        if (d < plan->pad) to[d] = ffp_bf16(x[e]);
    }
}

static __device__ void read_row(float x[FFP_ATTENTION_EACH], const float *from,
                                const FfpAttentionPlan *plan) {
#pragma unroll
    for (int e = 0; e < FFP_ATTENTION_EACH; e++) {
        const int d = ffp_lane() + e * FFP_WARP;
        x[e] = d < plan->dim ? from[d] : 0;
    }
}

// x / rms(x) gain scale
static __device__ void normalise(float x[FFP_ATTENTION_EACH], const float *gain, float scale,
                                 const FfpAttentionPlan *plan) {
    float sum = 0, g[FFP_ATTENTION_EACH];
    read_row(g, gain, plan);
#pragma unroll
    for (int e = 0; e < FFP_ATTENTION_EACH; e++) sum += x[e] * x[e];
    scale /= sqrtf(ffp_warp_sum(sum) / (float)plan->dim + EPSILON);
#pragma unroll
    for (int e = 0; e < FFP_ATTENTION_EACH; e++) x[e] *= scale * g[e];
}

// A warp for each row of each head.
static __global__ void prepare_rows(FfpAttentionPlan plan, FfpAttentionInput in, const float *dout,
                                    const float *out) {
    const size_t line = (size_t)blockIdx.x * WARPS + threadIdx.x / FFP_WARP;
    if (line >= (size_t)plan.rows * plan.heads) return;
    const int t = (int)(line / plan.heads), head = (int)(line % plan.heads);
    const size_t place = (size_t)head * plan.rows + t, column = (size_t)head * plan.dim;
    const float *row = in.qkv + (size_t)t * 3 * plan.width + column;
    float x[FFP_ATTENTION_EACH], other[FFP_ATTENTION_EACH];
    read_row(x, row, &plan);
    normalise(x, in.q_gain, FFP_ATTENTION_LOG2_E / sqrtf((float)plan.dim), &plan);
    write_row(plan.q + place * plan.pad, x, &plan);
    read_row(x, row + plan.width, &plan);
    normalise(x, in.k_gain, 1, &plan);
    write_row(plan.k + place * plan.pad, x, &plan);
    read_row(x, row + 2 * plan.width, &plan);
    write_row(plan.v + place * plan.pad, x, &plan);
    if (!dout) return;
    read_row(x, dout + (size_t)t * plan.width + column, &plan);
    read_row(other, out + (size_t)t * plan.width + column, &plan);
    write_row(plan.dout + place * plan.pad, x, &plan);
    float sum = 0;
    for (int e = 0; e < FFP_ATTENTION_EACH; e++) sum += x[e] * other[e];
    sum = ffp_warp_sum(sum);
    if (ffp_lane() == 0) plan.delta[place] = sum;
}

void ffp_cuda_attention_prepare(const FfpAttentionPlan *plan, const FfpAttentionInput *in, const float *dout,
                                const float *out) {
    const size_t lines = (size_t)plan->rows * plan->heads;
    ffp_launch_blocks(prepare_rows, dim3(ffp_blocks(lines, WARPS)), dim3(THREADS), 0, *plan, *in, dout, out);
}

bool ffp_cuda_attention_next(FfpAttentionTile *part, const FfpAttentionPlan *plan) {
    if (part->group == 0) {
        part->head = 0;
        part->query = 0;
    } else if (part->query + part->span < plan->rows) {
        part->query += part->span;
    } else {
        part->head += part->group;
        part->query = 0;
    }
    part->group = min(plan->group, plan->heads - part->head);
    part->span = min(plan->span, plan->rows - part->query);
    return part->group > 0 && part->span > 0;
}

void ffp_cuda_attention_scores(float *out, const FfpAttentionPlan *plan, const FfpAttentionTile *part,
                               const uint16_t *x, const uint16_t *y) {
    const size_t head = (size_t)plan->rows * plan->pad;
    const FfpCudaProduct product = {
        .operands = FFP_OPERANDS_BF16,
        .m = part->span,
        .n = plan->rows,
        .k = plan->pad,
        .alpha = 1,
        .a = {x + part->head * head + (size_t)part->query * plan->pad, plan->pad, false, head},
        .b = {y + part->head * head, plan->pad, true, head},
        .beta = 0,
        .c = out,
        .ldc = plan->keys,
        .stride_c = (size_t)part->span * plan->keys,
        .count = part->group};
    ffp_cuda_product(&product);
}

// A warp for each row of scores: softmax weights as bf16, and the logarithm of their sum. Each lane first
// finds the greatest score and the sum of its own part of a row.
static __global__ void softmax_rows(float *log_sum, FfpAttentionPlan plan, FfpAttentionTile part) {
    const size_t line = (size_t)blockIdx.x * WARPS + threadIdx.x / FFP_WARP;
    if (line >= (size_t)part.group * part.span) return;
    const float *scores = plan.scores + line * plan.keys;
    uint16_t *weights = plan.weights + line * plan.keys;
    float top = -INFINITY, sum = 0;
    for (int j = ffp_lane() * 2; j < plan.rows; j += 2 * FFP_WARP) {
        const float2 s = *(const float2 *)(scores + j);
        const float second = j + 1 < plan.rows ? s.y : -INFINITY, greatest = fmaxf(top, fmaxf(s.x, second));
        sum = sum * exp2f(top - greatest) + exp2f(s.x - greatest) + exp2f(second - greatest);
        top = greatest;
    }
    const float greatest = ffp_warp_max(top);
    sum = ffp_warp_sum(top > -INFINITY ? sum * exp2f(top - greatest) : 0);
    const float base = greatest + log2f(sum);
    for (int j = ffp_lane() * 2; j < plan.keys; j += 2 * FFP_WARP) {
        const float2 s = *(const float2 *)(scores + j);
        *(uint32_t *)(weights + j) =
            ffp_bf16_pair(j < plan.rows ? exp2f(s.x - base) : 0, j + 1 < plan.rows ? exp2f(s.y - base) : 0);
    }
    if (ffp_lane() == 0)
        log_sum[(part.head + line / part.span) * plan.rows + part.query + line % part.span] =
            base * FFP_ATTENTION_LN_2;
}

void ffp_cuda_attention_sum(float *to, int ldt, size_t stride, const uint16_t *weights, const uint16_t *x,
                            const FfpAttentionPlan *plan, const FfpAttentionTile *part) {
    const size_t head = (size_t)plan->rows * plan->pad;
    const FfpCudaProduct product = {.operands = FFP_OPERANDS_BF16,
                                    .m = part->span,
                                    .n = plan->dim,
                                    .k = plan->rows,
                                    .alpha = 1,
                                    .a = {weights, plan->keys, false, (size_t)part->span * plan->keys},
                                    .b = {x + part->head * head, plan->pad, false, head},
                                    .beta = 0,
                                    .c = to,
                                    .ldc = ldt,
                                    .stride_c = stride,
                                    .count = part->group};
    ffp_cuda_product(&product);
}

void ffp_cuda_attention_forward(float *out, float *log_sum, const FfpAttentionShape *shape,
                                const FfpAttentionInput *in, float *scratch) {
    if (shape->rows <= 0) return;
    const FfpAttentionPlan plan = ffp_cuda_attention_plan(shape, scratch);
    ffp_cuda_attention_prepare(&plan, in, NULL, NULL);
    for (FfpAttentionTile part = {}; ffp_cuda_attention_next(&part, &plan);) {
        ffp_cuda_attention_scores(plan.scores, &plan, &part, plan.q, plan.k);
        ffp_launch_blocks(softmax_rows, dim3(ffp_blocks((size_t)part.group * part.span, WARPS)),
                          dim3(THREADS), 0, log_sum, plan, part);
        ffp_cuda_attention_sum(out + (size_t)part.query * plan.width + part.head * plan.dim, plan.width,
                               (size_t)plan.dim, plan.weights, plan.v, &plan, &part);
    }
}
