// Softmax attention with RMS QK-norm, backward. The probabilities P are made again from log_sum. With dP = dO
// V^T and dS = P (dP - delta):  dV = P^T dO,  dK = dS^T Q,  dQ = dS K; then through the norms.
#include "engine/cuda/attention.h"
#include "engine/cuda/bf16.h"
#include "engine/cuda/columns.h"
#include "engine/cuda/products.h"
#include "engine/cuda/warp.h"

enum { THREADS = 256, WARPS = THREADS / FFP_WARP, NORM_BLOCKS = 256 };
#define EPSILON 1e-5f

// A thread for two keys of a row of scores; a row is the grid's y.
static __global__ void score_gradients(const float *log_sum, FfpAttentionPlan plan, FfpAttentionTile part) {
    const int j = 2 * (int)(blockIdx.x * THREADS + threadIdx.x);
    if (j >= plan.keys) return;
    for (size_t line = blockIdx.y; line < (size_t)part.group * part.span; line += gridDim.y) {
        const size_t at = (part.head + line / part.span) * plan.rows + part.query + line % part.span;
        const float base = log_sum[at] * FFP_ATTENTION_LOG2_E, delta = plan.delta[at];
        const size_t place = line * plan.keys + j;
        const float2 s = *(const float2 *)(plan.scores + place), d = *(const float2 *)(plan.dscores + place);
        const float first = j < plan.rows ? exp2f(s.x - base) : 0;
        const float second = j + 1 < plan.rows ? exp2f(s.y - base) : 0;
        const float dfirst = j < plan.rows ? first * (d.x - delta) : 0;
        const float dsecond = j + 1 < plan.rows ? second * (d.y - delta) : 0;
        *(uint32_t *)(plan.weights + place) = ffp_bf16_pair(first, second);
        *(uint32_t *)(plan.dweights + place) = ffp_bf16_pair(dfirst, dsecond);
    }
}

// to [T, dim] = alpha weights^T x of the part's queries, for each head: the first queries overwrite.
static void sum_over_queries(float *to, int ldt, size_t stride, float alpha, const uint16_t *weights,
                             const uint16_t *x, const FfpAttentionPlan *plan, const FfpAttentionTile *part) {
    const size_t head = (size_t)plan->rows * plan->pad;
    const FfpCudaProduct product = {
        .operands = FFP_OPERANDS_BF16,
        .m = plan->rows,
        .n = plan->dim,
        .k = part->span,
        .alpha = alpha,
        .a = {weights, plan->keys, true, (size_t)part->span * plan->keys},
        .b = {x + part->head * head + (size_t)part->query * plan->pad, plan->pad, false, head},
        .beta = part->query > 0 ? 1.0f : 0.0f,
        .c = to,
        .ldc = ldt,
        .stride_c = stride,
        .count = part->group};
    ffp_cuda_product(&product);
}

// Through the RMS norm of one row: dx = r (g - n mean(g n)) with n = x r, g = dy gain scale; adds to the
// gain's gradient.
static __device__ void norm_row(float *dx, float dgain[FFP_ATTENTION_EACH], const float *dy, const float *x,
                                const float *gain, float scale, int dim) {
    float squares = 0, along = 0, numbers[FFP_ATTENTION_EACH], gradients[FFP_ATTENTION_EACH];
#pragma unroll
    for (int e = 0; e < FFP_ATTENTION_EACH; e++) {
        const int d = ffp_lane() + e * FFP_WARP;
        numbers[e] = d < dim ? x[d] : 0;
        gradients[e] = d < dim ? dy[d] * scale : 0;
        squares += numbers[e] * numbers[e];
        along += d < dim ? gradients[e] * gain[d] * numbers[e] : 0;
    }
    const float inverse = 1 / sqrtf(ffp_warp_sum(squares) / (float)dim + EPSILON);
    along = ffp_warp_sum(along) * inverse * inverse / (float)dim;
#pragma unroll
    for (int e = 0; e < FFP_ATTENTION_EACH; e++) {
        const int d = ffp_lane() + e * FFP_WARP;
        if (d < dim) dx[d] = inverse * (gradients[e] * gain[d] - numbers[e] * along);
        dgain[e] += gradients[e] * numbers[e] * inverse;
    }
}

// Warps take rows of heads in turn. partial [blocks, 2 dim]: the block's share of dq_gain and dk_gain.
static __global__ void norm_backward(float *dqkv, float *partial, FfpAttentionInput in,
                                     FfpAttentionPlan plan) {
    __shared__ float sums[WARPS][2 * FFP_ATTENTION_DIM_MAX];
    const int warp = (int)threadIdx.x / FFP_WARP, dim = plan.dim;
    const size_t lines = (size_t)plan.rows * plan.heads;
    float dq_gain[FFP_ATTENTION_EACH] = {}, dk_gain[FFP_ATTENTION_EACH] = {};
    for (size_t line = (size_t)blockIdx.x * WARPS + warp; line < lines; line += (size_t)gridDim.x * WARPS) {
        const size_t t = line / plan.heads, head = line % plan.heads;
        const size_t at = t * 3 * plan.width + head * dim, place = (head * plan.rows + t) * plan.pad;
        norm_row(dqkv + at, dq_gain, plan.dq + place, in.qkv + at, in.q_gain, 1 / sqrtf((float)dim), dim);
        norm_row(dqkv + at + plan.width, dk_gain, plan.dk + place, in.qkv + at + plan.width, in.k_gain, 1,
                 dim);
    }
    for (int e = 0; e < FFP_ATTENTION_EACH; e++) {
        sums[warp][ffp_lane() + e * FFP_WARP] = dq_gain[e];
        sums[warp][FFP_ATTENTION_DIM_MAX + ffp_lane() + e * FFP_WARP] = dk_gain[e];
    }
    __syncthreads();
    for (int i = (int)threadIdx.x; i < 2 * dim; i += THREADS) {
        float sum = 0;
        for (int w = 0; w < WARPS; w++) sum += sums[w][i < dim ? i : FFP_ATTENTION_DIM_MAX + i - dim];
        partial[(size_t)blockIdx.x * 2 * dim + i] = sum;
    }
}

static void part_backward(float *dqkv, const float *log_sum, const FfpAttentionPlan *plan,
                          const FfpAttentionTile *part) {
    const size_t head = (size_t)plan->rows * plan->pad, lines = (size_t)part->group * part->span;
    ffp_cuda_attention_scores(plan->scores, plan, part, plan->q, plan->k);
    ffp_cuda_attention_scores(plan->dscores, plan, part, plan->dout, plan->v);
    ffp_launch(score_gradients,
               dim3(ffp_blocks((size_t)plan->keys / 2, THREADS), (unsigned)min(lines, (size_t)32768)),
               dim3(THREADS), log_sum, *plan, *part);
    sum_over_queries(dqkv + 2 * plan->width + part->head * plan->dim, 3 * plan->width, (size_t)plan->dim, 1,
                     plan->weights, plan->dout, plan, part);
    sum_over_queries(plan->dk + part->head * head, plan->pad, head, FFP_ATTENTION_LN_2, plan->dweights,
                     plan->q, plan, part);
    ffp_cuda_attention_sum(plan->dq + part->head * head + (size_t)part->query * plan->pad, plan->pad, head,
                           plan->dweights, plan->k, plan, part);
}

void ffp_cuda_attention_backward(const FfpAttentionGradient *grad, const FfpAttentionShape *shape,
                                 const FfpAttentionInput *in, const float *out, const float *log_sum,
                                 const float *dout, float *scratch) {
    const int dim = shape->head_dim;
    if (shape->rows <= 0) return;
    const FfpAttentionPlan plan = ffp_cuda_attention_plan(shape, scratch);
    ffp_cuda_attention_prepare(&plan, in, dout, out);
    for (FfpAttentionTile part = {}; ffp_cuda_attention_next(&part, &plan);)
        part_backward(grad->qkv, log_sum, &plan, &part);
    const unsigned blocks = min((unsigned)NORM_BLOCKS, ffp_blocks((size_t)shape->rows * shape->heads, WARPS));
    float *partial = ffp_cuda_column_partials((size_t)blocks * 2 * dim);
    ffp_launch_blocks(norm_backward, dim3(blocks), dim3(THREADS), 0, grad->qkv, partial, *in, plan);
    ffp_cuda_add_columns(partial, (int)blocks, grad->q_gain, dim, grad->k_gain, dim);
}
