// Softmax attention with RMS QK-norm, backward. The probabilities P are made anew from log_sum, transposed: a
// block has a row for each of its keys. With dS = P (dP - delta), dP = dO V^T:
//   dV = P^T dO,  dK = dS^T Q,  dQ^T = K^T dS^T.
// A thread takes a segment of keys and passes all queries; it follows the thread that has the segment before,
// so that dq is added to without copies and always in the same order: the same bits for any number of
// threads.
#include "tensor/kernels/attention_parts.h"

#include <string.h>
#include <tgmath.h>
#include "tensor/kernels/exp2.h"
#include "tensor/kernels/narrow.h"

enum { KEYS = 64 }; // a block of scores, KEYS x FFP_SEGMENT, lives on the thread's stack

typedef struct Backward {
    real *dqkv;
    const real *dout, *out, *log_sum, *qkv, *q_gain, *k_gain;
    FfpAttention a;
} Backward;

// Some keys of one segment against a segment of queries.
typedef struct Block {
    int keys, queries;
    size_t depth; // packed depth of queries
    real scores[KEYS * FFP_SEGMENT], dscores[KEYS * FFP_SEGMENT];
    FfpPacked weights[KEYS * FFP_SEGMENT], dweights[KEYS * FFP_SEGMENT]; // P^T and dS^T as rows of A
    FfpPacked columns[FFP_SEGMENT * FFP_SEGMENT]; // dS^T of all the segment's keys as columns of B
    real base[FFP_SEGMENT], delta[FFP_SEGMENT];   // of the queries: log_sum to base 2; dout . out
} Block;

static void dot_outputs(const Backward *pass, const FfpSegment *segment) {
    const FfpAttention *a = &pass->a;
    for (int i = 0; i < segment->rows; i++) {
        const int row = segment->first + i;
        const size_t first = (size_t)row * a->width + (size_t)segment->head * a->dim;
        real sum = 0;
#pragma omp simd reduction(+ : sum)
        for (int d = 0; d < a->dim; d++) sum += pass->dout[first + d] * pass->out[first + d];
        a->delta[(size_t)segment->head * a->rows + row] = sum;
    }
}

static void pack_segment(const Backward *pass, const FfpSegment *segment) {
    const FfpAttention *a = &pass->a;
    const int rows = segment->rows, dim = a->dim, width = a->width;
    const size_t column = (size_t)segment->head * dim, stage = ffp_attention_stage(a, segment);
    const real *v = pass->qkv + ((size_t)segment->first * 3 + 2) * width + column, *q = a->q + stage,
               *k = a->k + stage, *dout = pass->dout + (size_t)segment->first * width + column;
    FFP_K(attention_normalise)(a, segment, pass->qkv, pass->q_gain, pass->k_gain);
    dot_outputs(pass, segment);
    FFP_K(pack_rows)(ffp_attention_part(a, segment, FFP_K_ROWS), false, rows, dim, k, dim);
    FFP_K(pack_rows)(ffp_attention_part(a, segment, FFP_V_ROWS), false, rows, dim, v, 3 * width);
    FFP_K(pack_rows)(ffp_attention_part(a, segment, FFP_K_DEEP), true, dim, rows, k, dim);
    FFP_K(pack_columns)(ffp_attention_part(a, segment, FFP_Q_COLUMNS), true, dim, rows, q, dim);
    FFP_K(pack_columns)(ffp_attention_part(a, segment, FFP_DOUT_COLUMNS), true, dim, rows, dout, width);
    FFP_K(pack_columns)(ffp_attention_part(a, segment, FFP_Q_DEEP), false, rows, dim, q, dim);
    FFP_K(pack_columns)(ffp_attention_part(a, segment, FFP_DOUT_DEEP), false, rows, dim, dout, width);
}

// From scores and dP: P = 2^(score - log_sum) and dS = P (dP - delta), rounded.
static void score_gradients(Block *block) {
    const int queries = block->queries;
    for (int i = 0; i < block->keys; i++) {
        const real *scores = block->scores + (size_t)i * FFP_SEGMENT;
        const real *dscores = block->dscores + (size_t)i * FFP_SEGMENT;
        FfpPacked *weights = block->weights + (size_t)i * block->depth;
        FfpPacked *dweights = block->dweights + (size_t)i * block->depth;
#pragma omp simd
        for (int j = 0; j < queries; j++) {
            const real weight = ffp_exp2(scores[j] - block->base[j]);
            weights[j] = ffp_narrow(weight);
            dweights[j] = ffp_narrow(weight * (dscores[j] - block->delta[j]));
        }
        for (size_t j = (size_t)queries; j < block->depth; j++) weights[j] = dweights[j] = 0;
    }
}

// The block's dS^T, whose keys are those from `first` on, into the columns, whose k are the segment's keys.
// first is a multiple of FFP_PACK_DEPTH; zeros fill the last keys up to one.
static void spread_columns(Block *block, int first, size_t depth) {
    const int end = (int)ffp_packed_depth(block->keys);
    memset(block->dweights + (size_t)block->keys * block->depth, 0,
           (size_t)(end - block->keys) * block->depth * sizeof(FfpPacked));
    for (int column = 0; column < block->queries; column += FFP_PACK_LINES) {
        FfpPacked *out = block->columns + (size_t)column * depth + (size_t)first * FFP_PACK_LINES;
        for (int i = 0; i < end; i += FFP_PACK_GROUP) {
            const FfpPacked *rows = block->dweights + (size_t)i * block->depth + column;
            for (int j = 0; j < FFP_PACK_LINES; j++)
                for (int g = 0; g < FFP_PACK_GROUP; g++)
                    out[j * FFP_PACK_GROUP + g] = rows[(size_t)g * block->depth + j];
            out += FFP_PACK_LINES * FFP_PACK_GROUP;
        }
    }
}

// Keys [first, first + block->keys) of segment `to` against the queries of segment `from`: adds to their dv
// and dk, which the first queries overwrite (fresh 0).
static void attend_keys(const Backward *pass, Block *block, const FfpSegment *to, const FfpSegment *from,
                        int first, real fresh) {
    const FfpAttention *a = &pass->a;
    const size_t depth = a->depth;
    const int dim = a->dim, keys = block->keys, queries = block->queries;
    real *dv = pass->dqkv + ((size_t)(to->first + first) * 3 + 2) * a->width + (size_t)to->head * dim;
    real *dk = a->k + ffp_attention_stage(a, to) + (size_t)first * dim;
    FFP_K(product)
    (keys, queries, dim, 1, ffp_packed_row(ffp_attention_part(a, to, FFP_K_ROWS), first, 0, depth), depth,
     ffp_attention_part(a, from, FFP_Q_COLUMNS), depth, 0, block->scores, FFP_SEGMENT);
    FFP_K(product)
    (keys, queries, dim, 1, ffp_packed_row(ffp_attention_part(a, to, FFP_V_ROWS), first, 0, depth), depth,
     ffp_attention_part(a, from, FFP_DOUT_COLUMNS), depth, 0, block->dscores, FFP_SEGMENT);
    score_gradients(block);
    FFP_K(product)
    (keys, dim, queries, 1, block->weights, block->depth, ffp_attention_part(a, from, FFP_DOUT_DEEP),
     block->depth, fresh, dv, 3 * a->width);
    FFP_K(product)
    (keys, dim, queries, (real)FFP_LN_2, block->dweights, block->depth,
     ffp_attention_part(a, from, FFP_Q_DEEP), block->depth, fresh, dk, dim);
}

// All keys of segment `to` against the queries of segment `from`; the latter's dq^T is added to.
static void attend_pair(const Backward *pass, int head, int key_segment, int query_segment) {
    const FfpAttention *a = &pass->a;
    const FfpSegment to = FFP_K(attention_segment)(a, head, key_segment);
    const FfpSegment from = FFP_K(attention_segment)(a, head, query_segment);
    const size_t depth = ffp_packed_depth(to.rows), row = (size_t)head * a->rows + from.first;
    Block block;
    block.queries = from.rows, block.depth = ffp_packed_depth(from.rows);
    for (int j = 0; j < from.rows; j++) {
        block.base[j] = pass->log_sum[row + j] * (real)FFP_LOG2_E;
        block.delta[j] = a->delta[row + j];
    }
    for (int first = 0; first < to.rows; first += KEYS) {
        block.keys = ffp_smaller(KEYS, to.rows - first);
        attend_keys(pass, &block, &to, &from, first, query_segment > 0 ? 1 : 0);
        spread_columns(&block, first, depth);
    }
    FFP_K(product)
    (a->dim, from.rows, to.rows, 1, ffp_attention_part(a, &to, FFP_K_DEEP), depth, block.columns, depth,
     key_segment > 0 ? 1 : 0, a->q + ffp_attention_stage(a, &from), FFP_SEGMENT);
}

// Through the RMS norm of one row: dx = r (g - n mean(g n)) with n = x r, g = dy gain scale; adds to the
// gain's gradient.
static void norm_row_backward(real *dx, real *dgain, const real *dy, const real *x, const real *gain,
                              real inverse, real scale, int dim) {
    real along = 0;
#pragma omp simd reduction(+ : along)
    for (int d = 0; d < dim; d++) along += dy[d] * gain[d] * x[d];
    along *= inverse * inverse / (real)dim;
    for (int d = 0; d < dim; d++) {
        dx[d] = scale * inverse * (dy[d] * gain[d] - x[d] * along);
        dgain[d] += scale * inverse * dy[d] * x[d];
    }
}

// dq^T [dim, FFP_SEGMENT] to dq [rows, dim].
static void turn(real *dq, const real *transposed, int rows, int dim) {
    for (int d = 0; d < dim; d++)
        for (int i = 0; i < rows; i++) dq[(size_t)i * dim + d] = transposed[(size_t)d * FFP_SEGMENT + i];
}

static void norm_segment_backward(const Backward *pass, const FfpSegment *segment) {
    const FfpAttention *a = &pass->a;
    const int dim = a->dim;
    const size_t stage = ffp_attention_stage(a, segment), sum = segment->order * (size_t)dim;
    const real scale = 1 / sqrt((real)dim);
    real *dk = a->k + stage,
         *dq = (real *)ffp_attention_part(a, segment, FFP_K_ROWS); // the parts are done with
    memset(a->gain_sum[0] + sum, 0, sizeof(real) * (size_t)dim);
    memset(a->gain_sum[1] + sum, 0, sizeof(real) * (size_t)dim);
    turn(dq, a->q + stage, segment->rows, dim);
    for (int i = 0; i < segment->rows; i++) {
        const int row = segment->first + i;
        const size_t at = (size_t)row * 3 * a->width + (size_t)segment->head * dim;
        const size_t place = (size_t)segment->head * a->rows + row;
        norm_row_backward(pass->dqkv + at, a->gain_sum[0] + sum, dq + (size_t)i * dim, pass->qkv + at,
                          pass->q_gain, a->inverse[0][place], scale, dim);
        norm_row_backward(pass->dqkv + at + a->width, a->gain_sum[1] + sum, dk + (size_t)i * dim,
                          pass->qkv + at + a->width, pass->k_gain, a->inverse[1][place], 1, dim);
    }
}

static void add_sums(real *dgain, const real *gain_sum, const FfpAttention *a) {
    for (int i = 0; i < a->heads * a->segments; i++)
        for (int d = 0; d < a->dim; d++) dgain[d] += gain_sum[(size_t)i * a->dim + d];
}

static void for_segments(const Backward *pass, void (*run)(const Backward *, const FfpSegment *)) {
    const FfpAttention *a = &pass->a;
#pragma omp parallel for collapse(2) schedule(static)
    for (int head = 0; head < a->heads; head++) {
        for (int index = 0; index < a->segments; index++) {
            const FfpSegment segment = FFP_K(attention_segment)(a, head, index);
            run(pass, &segment);
        }
    }
}

void FFP_K(attention_backward)(real *dqkv, real *dq_gain, real *dk_gain, const real *dout, const real *out,
                               const real *log_sum, const real *qkv, const real *q_gain, const real *k_gain,
                               int rows, int heads, int head_dim, real *scratch) {
    const Backward pass = {dqkv, dout,   out,    log_sum,
                           qkv,  q_gain, k_gain, FFP_K(attention_layout)(rows, heads, head_dim, scratch)};
    const int segments = pass.a.segments;
    for_segments(&pass, pack_segment);
#pragma omp parallel for ordered(2) schedule(static, 1)
    for (int keys = 0; keys < heads * segments; keys++) {
        for (int queries = 0; queries < segments; queries++) {
#pragma omp ordered depend(sink : keys - 1, queries)
            attend_pair(&pass, keys / segments, keys % segments, queries);
#pragma omp ordered depend(source)
        }
    }
    for_segments(&pass, norm_segment_backward);
    add_sums(dq_gain, pass.a.gain_sum[0], &pass.a);
    add_sums(dk_gain, pass.a.gain_sum[1], &pass.a);
}
