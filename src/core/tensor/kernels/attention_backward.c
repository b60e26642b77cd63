// Softmax attention with RMS QK-norm, backward. The probabilities P are made again from log_sum, transposed:
// a block has a row for each of its keys. With dS = P (dP - delta), dP = dO V^T:
//   dV = P^T dO,  dK = dS^T Q,  dQ^T = K^T dS^T.
// A thread takes a segment of keys and passes all queries; it follows the thread that has the segment before,
// so that dq is added to without copies and always in the same order: the same bits for any number of
// threads.
#include <omp.h>
#include <string.h>
#include <tgmath.h>
#include "core/tensor/kernels/attention_parts.h"
#include "core/tensor/kernels/exp2.h"
#include "core/tensor/kernels/softmax.h"

enum { KEYS = 64, QUERIES = 128 }; // a block of scores, KEYS x QUERIES, lives on the thread's stack

typedef struct Backward {
    const FfpAttentionGradient *grad;
    const FfpAttentionInput *in;
    const real *out, *log_sum, *dout;
    FfpAttention a;
} Backward;

typedef struct Block {
    real scores[KEYS * QUERIES], dscores[KEYS * QUERIES];
    FfpPacked weights[KEYS * QUERIES], dweights[KEYS * QUERIES]; // P^T and dS^T as rows of A
    FfpPacked columns[QUERIES * FFP_SEGMENT]; // dS^T of all keys of the segment as columns of B
} Block;

// Queries of one segment.
typedef struct Queries {
    FfpSegment segment;
    int first, count; // from the segment's row `first` on
} Queries;

// base and delta of a segment.
static void query_sums(const Backward *pass, const FfpSegment *segment) {
    const FfpAttention *a = &pass->a;
    for (int i = 0; i < segment->rows; i++) {
        const int row = segment->first + i;
        const size_t first = (size_t)row * a->width + (size_t)segment->head * a->dim;
        real sum = 0;
#pragma omp simd reduction(+ : sum)
        for (int d = 0; d < a->dim; d++) sum += pass->dout[first + d] * pass->out[first + d];
        const size_t at = (size_t)segment->head * a->rows + row;
        a->base[at] = pass->log_sum[at] * (real)FFP_LOG2_E;
        a->delta[at] = sum;
    }
}

static void pack_segment(const Backward *pass, const FfpSegment *segment) {
    const FfpAttention *a = &pass->a;
    const int rows = segment->rows, dim = a->dim, width = a->width;
    const size_t column = (size_t)segment->head * dim, stage = ffp_attention_stage(a, segment);
    const real *v = pass->in->qkv + ((size_t)segment->first * 3 + 2) * width + column, *q = a->q + stage,
               *k = a->k + stage, *dout = pass->dout + (size_t)segment->first * width + column;
    FFP_K(attention_normalise)(a, segment, pass->in);
    query_sums(pass, segment);
    FFP_K(pack_rows)(ffp_attention_operand(a, segment, FFP_K_ROWS), false, rows, dim, k, dim);
    FFP_K(pack_rows)(ffp_attention_operand(a, segment, FFP_V_ROWS), false, rows, dim, v, 3 * width);
    FFP_K(pack_rows)(ffp_attention_operand(a, segment, FFP_K_DEEP), true, dim, rows, k, dim);
    FFP_K(pack_columns)(ffp_attention_operand(a, segment, FFP_Q_COLUMNS), true, dim, rows, q, dim);
    FFP_K(pack_columns)(ffp_attention_operand(a, segment, FFP_DOUT_COLUMNS), true, dim, rows, dout, width);
    FFP_K(pack_columns)(ffp_attention_operand(a, segment, FFP_Q_DEEP), false, rows, dim, q, dim);
    FFP_K(pack_columns)(ffp_attention_operand(a, segment, FFP_DOUT_DEEP), false, rows, dim, dout, width);
}

// The segment's keys from `first` on against the queries: adds to the keys' dv and dk, which the head's first
// queries overwrite, and fills these keys' part of the columns.
static void attend_keys(const Backward *pass, Block *block, const FfpSegment *keys, int first,
                        const Queries *queries) {
    const FfpAttention *a = &pass->a;
    const FfpSegment *from = &queries->segment;
    const int dim = a->dim, width = a->width, count = ffp_smaller(KEYS, keys->rows - first),
              n = queries->count;
    const size_t row = (size_t)from->head * a->rows + from->first + queries->first;
    const size_t depth = ffp_packed_depth(n), key_depth = ffp_packed_depth(keys->rows);
    const FfpSoftmaxBlock softmax = {count,           n,
                                     QUERIES,         block->scores,
                                     block->dscores,  a->base + row,
                                     a->delta + row,  block->weights,
                                     block->dweights, block->columns + (size_t)first * FFP_PACK_LINES,
                                     key_depth};
    const real fresh = from->first + queries->first > 0 ? 1 : 0;
    real *dv = pass->grad->qkv + ((size_t)(keys->first + first) * 3 + 2) * width + (size_t)keys->head * dim;
    real *dk = a->k + ffp_attention_stage(a, keys) + (size_t)first * dim;
    ffp_product(count, n, dim, 1, ffp_flat_rows(a, keys, FFP_K_ROWS, first),
                ffp_flat_columns(a, from, FFP_Q_COLUMNS, queries->first), 0, block->scores, QUERIES);
    ffp_product(count, n, dim, 1, ffp_flat_rows(a, keys, FFP_V_ROWS, first),
                ffp_flat_columns(a, from, FFP_DOUT_COLUMNS, queries->first), 0, block->dscores, QUERIES);
    FFP_K(softmax_gradients)(&softmax);
    ffp_product(count, dim, n, 1, (FfpOperand){block->weights, depth},
                ffp_deep_columns(a, from, FFP_DOUT_DEEP, queries->first), fresh, dv, 3 * width);
    ffp_product(count, dim, n, (real)FFP_LN_2, (FfpOperand){block->dweights, depth},
                ffp_deep_columns(a, from, FFP_Q_DEEP, queries->first), fresh, dk, dim);
}

// All keys of a segment against all queries of another; the latter's dq^T is added to.
static void attend_pair(const Backward *pass, int head, int key_segment, int query_segment) {
    const FfpAttention *a = &pass->a;
    const FfpSegment keys = FFP_K(attention_segment)(a, head, key_segment);
    Queries queries = {.segment = FFP_K(attention_segment)(a, head, query_segment)};
    const size_t depth = ffp_packed_depth(keys.rows);
    const FfpOperand k = {ffp_attention_operand(a, &keys, FFP_K_DEEP), depth};
    real *dq = a->q + ffp_attention_stage(a, &queries.segment);
    Block block;
    for (; queries.first < queries.segment.rows; queries.first += QUERIES) {
        queries.count = ffp_smaller(QUERIES, queries.segment.rows - queries.first);
        for (int first = 0; first < keys.rows; first += KEYS)
            attend_keys(pass, &block, &keys, first, &queries);
        ffp_product(a->dim, queries.count, keys.rows, 1, k, (FfpOperand){block.columns, depth},
                    key_segment > 0 ? 1 : 0, dq + queries.first, FFP_SEGMENT);
    }
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
         *dq = (real *)ffp_attention_operand(a, segment, FFP_K_ROWS); // the parts are done with
    memset(a->gain_sum[0] + sum, 0, sizeof(real) * (size_t)dim);
    memset(a->gain_sum[1] + sum, 0, sizeof(real) * (size_t)dim);
    turn(dq, a->q + stage, segment->rows, dim);
    for (int i = 0; i < segment->rows; i++) {
        const int row = segment->first + i;
        const size_t at = (size_t)row * 3 * a->width + (size_t)segment->head * dim;
        const size_t place = (size_t)segment->head * a->rows + row;
        norm_row_backward(pass->grad->qkv + at, a->gain_sum[0] + sum, dq + (size_t)i * dim,
                          pass->in->qkv + at, pass->in->q_gain, a->inverse[0][place], scale, dim);
        norm_row_backward(pass->grad->qkv + at + a->width, a->gain_sum[1] + sum, dk + (size_t)i * dim,
                          pass->in->qkv + at + a->width, pass->in->k_gain, a->inverse[1][place], 1, dim);
    }
}

// `span` segments of keys from `keys` on against `span` segments of queries, keys outside: what belongs to
// them stays in the cache.
static void attend_square(const Backward *pass, int head, int keys, int queries, int span) {
    const int key_end = ffp_smaller(keys + span, pass->a.segments),
              query_end = ffp_smaller(queries + span, pass->a.segments);
    for (int k = keys; k < key_end; k++)
        for (int q = queries; q < query_end; q++) attend_pair(pass, head, k, q);
}

// Squares of the grid of keys and queries. Those on one diagonal share neither and run side by side; each
// waits for the diagonal before. With one square a head, heads run side by side.
static void attend_all(const Backward *pass, int span) {
    const int squares = (pass->a.segments + span - 1) / span;
#pragma omp parallel
    for (int diagonal = 0; diagonal < 2 * squares - 1; diagonal++) {
        const int first = diagonal < squares ? 0 : diagonal - squares + 1;
        const int count = ffp_smaller(diagonal, squares - 1) - first + 1;
#pragma omp for schedule(static)
        for (int task = 0; task < pass->a.heads * count; task++) {
            const int keys = first + task % count;
            attend_square(pass, task / count, keys * span, (diagonal - keys) * span, span);
        }
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

void FFP_K(attention_backward)(const FfpAttentionGradient *grad, const FfpAttentionShape *shape,
                               const FfpAttentionInput *in, const real *out, const real *log_sum,
                               const real *dout, real *scratch) {
    const Backward pass = {grad, in, out, log_sum, dout, FFP_K(attention_layout)(shape, scratch)};
    for_segments(&pass, pack_segment);
    attend_all(&pass, shape->heads % omp_get_max_threads() == 0 ? pass.a.segments : 1);
    for_segments(&pass, norm_segment_backward);
    add_sums(grad->q_gain, pass.a.gain_sum[0], &pass.a);
    add_sums(grad->k_gain, pass.a.gain_sum[1], &pass.a);
}
