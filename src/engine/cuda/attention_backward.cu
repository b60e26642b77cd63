// Softmax attention with RMS QK-norm, backward. The probabilities P are made again from log_sum. With dP = dO
// V^T and dS = P (dP - delta):  dV = P^T dO,  dK = dS^T Q,  dQ = dS K; then through the norms.
#include "engine/cuda/attention.h"
#include "engine/cuda/columns.h"

enum { THREADS = 256, WARPS = THREADS / FFP_WARP, NORM_BLOCKS = 256, NARROW = FFP_ATTENTION_TILE / 8 };
#define EPSILON 1e-5f

// dQ, a block for a tile of queries.
template <int PAD>
static __global__ void __launch_bounds__(FFP_ATTENTION_THREADS)
    queries_backward(const float *log_sum, FfpAttentionPlan plan) {
    __shared__ FfpAttentionTile<PAD> keys, values;
    const size_t line = (size_t)blockIdx.y * plan.rows, head = line * PAD;
    float base[2], delta[2], sums[PAD / 8][4] = {};
    uint32_t query[PAD / 16][4], dout[PAD / 16][4];
    ffp_attention_own<PAD>(query, plan.q + head, plan.rows);
    ffp_attention_own<PAD>(dout, plan.dout + head, plan.rows);
    for (int h = 0; h < 2; h++) {
        const int row = ffp_attention_row(h);
        base[h] = row < plan.rows ? log_sum[line + row] * FFP_ATTENTION_LOG2_E : INFINITY;
        delta[h] = row < plan.rows ? plan.delta[line + row] : 0;
    }
    for (int first = 0; first < plan.rows; first += FFP_ATTENTION_TILE) {
        float scores[NARROW][4], dscores[NARROW][4];
        __syncthreads();
        ffp_attention_fill(&keys, plan.k + head, first, plan.rows);
        ffp_attention_fill(&values, plan.v + head, first, plan.rows);
        __syncthreads();
        ffp_attention_scores<PAD>(scores, query, &keys);
        ffp_attention_scores<PAD>(dscores, dout, &values);
#pragma unroll
        for (int n = 0; n < NARROW; n++)
#pragma unroll
            for (int i = 0; i < 4; i++) {
                const bool key = first + ffp_attention_column(n, i) < plan.rows;
                const float weight = key ? exp2f(scores[n][i] - base[i / 2]) : 0;
                dscores[n][i] = weight * (dscores[n][i] - delta[i / 2]);
            }
        ffp_attention_add<PAD>(sums, dscores, &keys);
    }
    const float scale[2] = {1, 1};
    ffp_attention_write<PAD>(plan.dq + head, PAD, sums, scale, &plan);
}

// dK and dV, a block for a tile of keys.
template <int PAD>
static __global__ void __launch_bounds__(FFP_ATTENTION_THREADS)
    keys_backward(float *dvalues, const float *log_sum, FfpAttentionPlan plan) {
    __shared__ FfpAttentionTile<PAD> queries, douts;
    __shared__ float base[FFP_ATTENTION_TILE], delta[FFP_ATTENTION_TILE];
    const size_t line = (size_t)blockIdx.y * plan.rows, head = line * PAD;
    float dk[PAD / 8][4] = {}, dv[PAD / 8][4] = {};
    uint32_t key[PAD / 16][4], value[PAD / 16][4];
    ffp_attention_own<PAD>(key, plan.k + head, plan.rows);
    ffp_attention_own<PAD>(value, plan.v + head, plan.rows);
    for (int first = 0; first < plan.rows; first += FFP_ATTENTION_TILE) {
        float scores[NARROW][4], dscores[NARROW][4];
        __syncthreads();
        ffp_attention_fill(&queries, plan.q + head, first, plan.rows);
        ffp_attention_fill(&douts, plan.dout + head, first, plan.rows);
        for (int i = (int)threadIdx.x; i < FFP_ATTENTION_TILE; i += FFP_ATTENTION_THREADS) {
            const bool query = first + i < plan.rows;
            base[i] = query ? log_sum[line + first + i] * FFP_ATTENTION_LOG2_E : INFINITY;
            delta[i] = query ? plan.delta[line + first + i] : 0;
        }
        __syncthreads();
        ffp_attention_scores<PAD>(scores, key, &queries);
        ffp_attention_scores<PAD>(dscores, value, &douts);
#pragma unroll
        for (int n = 0; n < NARROW; n++)
#pragma unroll
            for (int i = 0; i < 4; i++) {
                const int query = ffp_attention_column(n, i);
                scores[n][i] = exp2f(scores[n][i] - base[query]);
                dscores[n][i] = scores[n][i] * (dscores[n][i] - delta[query]);
            }
        ffp_attention_add<PAD>(dv, scores, &douts);
        ffp_attention_add<PAD>(dk, dscores, &queries);
    }
    const float one[2] = {1, 1}, to_base_e[2] = {FFP_ATTENTION_LN_2, FFP_ATTENTION_LN_2};
    ffp_attention_write<PAD>(dvalues + blockIdx.y * plan.dim, 3 * (size_t)plan.width, dv, one, &plan);
    ffp_attention_write<PAD>(plan.dk + head, PAD, dk, to_base_e, &plan);
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

void ffp_cuda_attention_backward(const FfpAttentionGradient *grad, const FfpAttentionShape *shape,
                                 const FfpAttentionInput *in, const float *out, const float *log_sum,
                                 const float *dout, float *scratch) {
    const int dim = shape->head_dim;
    if (shape->rows <= 0) return;
    const FfpAttentionPlan plan = ffp_cuda_attention_plan(shape, scratch);
    ffp_cuda_attention_prepare(&plan, in, dout, out);
    const dim3 grid = ffp_attention_grid(&plan), block(FFP_ATTENTION_THREADS);
    ffp_launch_blocks(plan.pad == 64 ? queries_backward<64> : queries_backward<128>, grid, block, 0, log_sum,
                      plan);
    ffp_launch_blocks(plan.pad == 64 ? keys_backward<64> : keys_backward<128>, grid, block, 0,
                      grad->qkv + 2 * plan.width, log_sum, plan);
    const unsigned blocks = min((unsigned)NORM_BLOCKS, ffp_blocks((size_t)shape->rows * shape->heads, WARPS));
    float *partial = ffp_cuda_column_partials((size_t)blocks * 2 * dim);
    ffp_launch_blocks(norm_backward, dim3(blocks), dim3(THREADS), 0, grad->qkv, partial, *in, plan);
    ffp_cuda_add_columns(partial, (int)blocks, grad->q_gain, dim, grad->k_gain, dim);
}
