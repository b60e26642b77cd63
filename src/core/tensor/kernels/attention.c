// Softmax attention with RMS QK-norm, forward: blocks of queries against segments of keys (the online softmax
// of Dao et al. 2022), so that no matrix of T x T is ever in memory.
#include <tgmath.h>
#include "core/tensor/kernels/attention_parts.h"
#include "core/tensor/kernels/exp2.h"
#include "core/tensor/kernels/softmax.h"

enum { QUERIES = 128 }; // a block of scores and weights, QUERIES x FFP_SEGMENT, lives on the thread's stack

// Scores (to base e) up to this are raised as they are: e^60 times any number of rows and any sensible v is
// far from fp32's and bf16's limits, 2^127.
#define SAFE_SCORE 60

// A block of queries on its way over the keys.
typedef struct Block {
    int queries, keys;
    size_t depth; // packed depth of keys
    real scores[QUERIES * FFP_SEGMENT];
    FfpPacked weights[QUERIES * FFP_SEGMENT]; // rows of A
    real top[QUERIES];                        // what the weights' exponents are taken from
    real sum[QUERIES];                        // of weights so far
    real parts[QUERIES * FFP_PACK_LINES];     // of those sums, where product_weights makes the weights
} Block;

static void pack_segment(const FfpAttention *a, const FfpSegment *segment, const FfpAttentionInput *in) {
    const int rows = segment->rows, dim = a->dim;
    const real *v = in->qkv + ((size_t)segment->first * 3 + 2) * a->width + (size_t)segment->head * dim;
    const size_t stage = ffp_attention_stage(a, segment);
    FFP_K(attention_normalise)(a, segment, in);
    FFP_K(pack_rows)(ffp_attention_operand(a, segment, FFP_Q_ROWS), false, rows, dim, a->q + stage, dim);
    FFP_K(pack_columns)(ffp_attention_operand(a, segment, FFP_K_COLUMNS), true, dim, rows, a->k + stage, dim);
    FFP_K(pack_columns)(ffp_attention_operand(a, segment, FFP_V_DEEP), false, rows, dim, v, 3 * a->width);
}

// |q . k| / sqrt(dim) of normalised rows is at most sqrt(dim) max |gains' product| (Cauchy and Schwarz).
static bool scores_are_safe(const FfpAttentionInput *in, int dim) {
    real greatest = 0;
    for (int i = 0; i < dim; i++) {
        const real gain = fabs(in->q_gain[i] * in->k_gain[i]);
        if (!(gain <= greatest)) greatest = gain; // NaN is not safe
    }
    return sqrt((real)dim) * greatest <= SAFE_SCORE;
}

// From the scores' operands q and k to weights, where no running maximum is needed.
static void weigh_safe(Block *block, FfpOperand q, FfpOperand k, int dim) {
#ifdef FFP_PRODUCT_WEIGHTS
    if (block->keys % FFP_PACK_DEPTH == 0) {
        FFP_K(product_weights)
        (block->queries, block->keys, dim, q, k, block->weights, block->parts);
        return;
    }
#endif
    ffp_product(block->queries, block->keys, dim, 1, q, k, 0, block->scores, FFP_SEGMENT);
    for (int i = 0; i < block->queries; i++)
        block->sum[i] += FFP_K(softmax_row)(block->weights + (size_t)i * block->depth,
                                            block->scores + (size_t)i * FFP_SEGMENT, 0, block->keys);
}

// The greatest of `count` scores and `top`, in lanes that are compared at the end.
static real greatest_score(const real *scores, int count, real top) {
    real lanes[FFP_PACK_LINES];
    const int whole = count / FFP_PACK_LINES * FFP_PACK_LINES;
    for (int lane = 0; lane < FFP_PACK_LINES; lane++) lanes[lane] = top;
    for (int j = 0; j < whole; j += FFP_PACK_LINES) {
#pragma omp simd
        for (int lane = 0; lane < FFP_PACK_LINES; lane++)
            lanes[lane] = scores[j + lane] > lanes[lane] ? scores[j + lane] : lanes[lane];
    }
    for (int j = whole; j < count; j++) top = scores[j] > top ? scores[j] : top;
    for (int lane = 0; lane < FFP_PACK_LINES; lane++) top = lanes[lane] > top ? lanes[lane] : top;
    return top;
}

// Keeps each row's greatest score in `top`; what was gathered with an older one is scaled down to it.
static void weigh_online(Block *block, FfpOperand q, FfpOperand k, real *out, const FfpAttention *a) {
    ffp_product(block->queries, block->keys, a->dim, 1, q, k, 0, block->scores, FFP_SEGMENT);
    for (int i = 0; i < block->queries; i++) {
        const real *scores = block->scores + (size_t)i * FFP_SEGMENT;
        const real greatest = greatest_score(scores, block->keys, block->top[i]);
        real *out_row = out + (size_t)i * a->width;
        if (greatest > block->top[i] && block->sum[i] > 0) {
            const real factor = ffp_exp2(block->top[i] - greatest);
            block->sum[i] *= factor;
            for (int d = 0; d < a->dim; d++) out_row[d] *= factor;
        }
        block->top[i] = greatest;
        block->sum[i] +=
            FFP_K(softmax_row)(block->weights + (size_t)i * block->depth, scores, greatest, block->keys);
    }
}

// `queries` rows from the segment's `first` on against all keys of the head.
static void attend_block(real *out, real *log_sum, const FfpAttention *a, const FfpSegment *from, int first,
                         int queries, bool safe) {
    const FfpOperand q = ffp_flat_rows(a, from, FFP_Q_ROWS, first);
    Block block;
    block.queries = queries;
    out += (size_t)(from->first + first) * a->width + (size_t)from->head * a->dim;
    log_sum += (size_t)from->head * a->rows + from->first + first;
    for (int i = 0; i < queries; i++) {
        block.top[i] = safe ? 0 : -INFINITY;
        block.sum[i] = 0;
    }
    for (int i = 0; i < queries * FFP_PACK_LINES; i++) block.parts[i] = 0;
    for (int index = 0; index < a->segments; index++) {
        const FfpSegment to = FFP_K(attention_segment)(a, from->head, index);
        block.keys = to.rows;
        block.depth = ffp_packed_depth(to.rows);
        const FfpOperand k = ffp_flat_columns(a, &to, FFP_K_COLUMNS, 0);
        if (safe)
            weigh_safe(&block, q, k, a->dim);
        else
            weigh_online(&block, q, k, out, a);
        ffp_product(queries, a->dim, to.rows, 1, (FfpOperand){block.weights, block.depth},
                    ffp_deep_columns(a, &to, FFP_V_DEEP, 0), index > 0 ? 1 : 0, out, a->width);
    }
    for (int i = 0; i < queries; i++) {
        for (int lane = 0; lane < FFP_PACK_LINES; lane++)
            block.sum[i] += block.parts[i * FFP_PACK_LINES + lane];
        const real inverse = 1 / block.sum[i];
        for (int d = 0; d < a->dim; d++) out[(size_t)i * a->width + d] *= inverse;
        log_sum[i] = block.top[i] * (real)FFP_LN_2 + log(block.sum[i]);
    }
}

void FFP_K(attention_forward)(real *out, real *log_sum, const FfpAttentionShape *shape,
                              const FfpAttentionInput *in, real *scratch) {
    const FfpAttention a = FFP_K(attention_layout)(shape, scratch);
    const bool safe = scores_are_safe(in, a.dim);
#pragma omp parallel for collapse(2) schedule(static)
    for (int head = 0; head < a.heads; head++) {
        for (int index = 0; index < a.segments; index++) {
            const FfpSegment segment = FFP_K(attention_segment)(&a, head, index);
            pack_segment(&a, &segment, in);
        }
    }
#pragma omp parallel for collapse(2) schedule(static)
    for (int head = 0; head < a.heads; head++) {
        for (int row = 0; row < a.rows; row += QUERIES) {
            const FfpSegment segment = FFP_K(attention_segment)(&a, head, row / FFP_SEGMENT);
            attend_block(out, log_sum, &a, &segment, row % FFP_SEGMENT, ffp_smaller(QUERIES, a.rows - row),
                         safe);
        }
    }
}
