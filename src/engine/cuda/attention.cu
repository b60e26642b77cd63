// Softmax attention with RMS QK-norm, forward.
#include "engine/cuda/attention.h"

enum { THREADS = 256, WARPS = THREADS / FFP_WARP };
#define EPSILON 1e-5f

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
    plan.pad = dim <= 64 ? 64 : 128;
    return plan;
}

// Sizes in reals, in the order of FfpAttentionPlan.
enum { HALVES = 4, WHOLES = 3, PARTS = HALVES + WHOLES };
static void part_sizes(size_t sizes[PARTS], const FfpAttentionPlan *p) {
    const size_t lines = (size_t)p->heads * p->rows, numbers = lines * p->pad;
    const size_t parts[PARTS] = {numbers / 2, numbers / 2, numbers / 2, numbers / 2, lines, numbers, numbers};
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
    uint16_t **halves[HALVES] = {&plan.q, &plan.k, &plan.v, &plan.dout};
    float **wholes[WHOLES] = {&plan.delta, &plan.dq, &plan.dk};
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

// The greatest, or the sum, of what the four lanes of a row have.
static __device__ float quad_max(float x) {
    x = fmaxf(x, __shfl_xor_sync(0xffffffffu, x, 1));
    return fmaxf(x, __shfl_xor_sync(0xffffffffu, x, 2));
}
static __device__ float quad_sum(float x) {
    x += __shfl_xor_sync(0xffffffffu, x, 1);
    return x + __shfl_xor_sync(0xffffffffu, x, 2);
}

enum { NARROW = FFP_ATTENTION_TILE / 8 }; // sums across a tile

// Of one row: scores become weights against the greatest score so far, and what was summed before shrinks to
// it. A lane's `total` is of its own columns.
template <int PAD>
static __device__ void weigh(float scores[NARROW][4], float sums[PAD / 8][4], int h, float *top,
                             float *total) {
    float greatest = *top;
#pragma unroll
    for (int n = 0; n < NARROW; n++)
        greatest = fmaxf(greatest, fmaxf(scores[n][2 * h], scores[n][2 * h + 1]));
    greatest = quad_max(greatest);
    const float shrink = exp2f(*top - greatest);
    *total *= shrink;
#pragma unroll
    for (int n = 0; n < NARROW; n++)
#pragma unroll
        for (int i = 2 * h; i < 2 * h + 2; i++) *total += scores[n][i] = exp2f(scores[n][i] - greatest);
#pragma unroll
    for (int n = 0; n < PAD / 8; n++)
#pragma unroll
        for (int i = 2 * h; i < 2 * h + 2; i++) sums[n][i] *= shrink;
    *top = greatest;
}

template <int PAD>
static __global__ void __launch_bounds__(FFP_ATTENTION_THREADS)
    attend(float *out, float *log_sum, FfpAttentionPlan plan) {
    __shared__ FfpAttentionTile<PAD> keys, values;
    const size_t head = (size_t)blockIdx.y * plan.rows * PAD;
    float top[2] = {-INFINITY, -INFINITY}, total[2] = {}, sums[PAD / 8][4] = {};
    uint32_t own[PAD / 16][4];
    ffp_attention_own<PAD>(own, plan.q + head, plan.rows);
    for (int first = 0; first < plan.rows; first += FFP_ATTENTION_TILE) {
        float scores[NARROW][4];
        __syncthreads();
        ffp_attention_fill(&keys, plan.k + head, first, plan.rows);
        ffp_attention_fill(&values, plan.v + head, first, plan.rows);
        __syncthreads();
        ffp_attention_scores<PAD>(scores, own, &keys);
        if (first + FFP_ATTENTION_TILE > plan.rows)
#pragma unroll
            for (int n = 0; n < NARROW; n++)
#pragma unroll
                for (int i = 0; i < 4; i++)
                    if (first + ffp_attention_column(n, i) >= plan.rows) scores[n][i] = -INFINITY;
#pragma unroll
        for (int h = 0; h < 2; h++) weigh<PAD>(scores, sums, h, &top[h], &total[h]);
        ffp_attention_add<PAD>(sums, scores, &values);
    }
    float scale[2];
    for (int h = 0; h < 2; h++) {
        const float sum = quad_sum(total[h]);
        const int row = ffp_attention_row(h);
        scale[h] = 1 / sum;
        if (ffp_lane() % 4 == 0 && row < plan.rows)
            log_sum[(size_t)blockIdx.y * plan.rows + row] = (top[h] + log2f(sum)) * FFP_ATTENTION_LN_2;
    }
    ffp_attention_write<PAD>(out + blockIdx.y * plan.dim, (size_t)plan.width, sums, scale, &plan);
}

void ffp_cuda_attention_forward(float *out, float *log_sum, const FfpAttentionShape *shape,
                                const FfpAttentionInput *in, float *scratch) {
    if (shape->rows <= 0) return;
    const FfpAttentionPlan plan = ffp_cuda_attention_plan(shape, scratch);
    ffp_cuda_attention_prepare(&plan, in, NULL, NULL);
    ffp_launch_blocks(plan.pad == 64 ? attend<64> : attend<128>, ffp_attention_grid(&plan),
                      dim3(FFP_ATTENTION_THREADS), 0, out, log_sum, plan);
}
