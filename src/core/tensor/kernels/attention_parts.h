// Common parts of attention's two passes: the layout of the scratch, the normalised and packed rows. Inside
// the kernels folder only.
//
// The rows of each head are cut into segments of FFP_SEGMENT. The operands of a product are packed once for
// each segment. Scores are kept to base 2: q carries log2(e) / sqrt(head_dim), so that the softmax weight is
// 2^score.
#ifndef FFP_TENSOR_KERNELS_ATTENTION_PARTS_H
#define FFP_TENSOR_KERNELS_ATTENTION_PARTS_H

#include "core/base/integer.h"
#include "core/tensor/kernels/kernels.h"
#include "core/tensor/kernels/product.h"

enum { FFP_SEGMENT = 256 };

// Packed operands of a segment: X as rows of A or columns of B [dim of them deep], or with the segment's rows
// along k ("deep").
typedef enum FfpAttentionOperand {
    // forward
    FFP_Q_ROWS,
    FFP_K_COLUMNS,
    FFP_V_DEEP,
    FFP_FORWARD_OPERANDS,
    // backward
    FFP_K_ROWS = 0,
    FFP_V_ROWS,
    FFP_K_DEEP, // K^T as A; the other deep ones are B
    FFP_Q_COLUMNS,
    FFP_DOUT_COLUMNS,
    FFP_Q_DEEP,
    FFP_DOUT_DEEP,
    FFP_ATTENTION_OPERANDS
} FfpAttentionOperand;

// One segment of one head.
typedef struct FfpSegment {
    int head, index, first, rows;
    size_t order; // its place among all segments of all heads
} FfpSegment;

typedef struct FfpAttention {
    int rows, heads, dim, width, segments; // width = heads * dim; segments of one head
    size_t depth, part_size;               // packed depth of dim; numbers of one packed part
    real *q, *k; // [heads, segments, FFP_SEGMENT, dim]: normalised; the backward's dq^T and dk afterwards
    real *inverse[2];   // [heads, T] for q and for k: 1 / root mean square
    real *base, *delta; // [heads, T]: log_sum to base 2; dout . out
    real *gain_sum[2];  // [heads, segments, dim] for q and for k
    FfpPacked *packed;  // [heads, segments, FFP_ATTENTION_OPERANDS, part_size]
} FfpAttention;

FfpAttention FFP_K(attention_layout)(const FfpAttentionShape *shape, real *scratch);
FfpSegment FFP_K(attention_segment)(const FfpAttention *a, int head, int index);

// q and k of a segment, normalised: q = x / rms(x) gain log2(e) / sqrt(dim), k = x / rms(x) gain. Fills
// inverse.
void FFP_K(attention_normalise)(const FfpAttention *a, const FfpSegment *segment,
                                const FfpAttentionInput *in);

// Where a segment's rows begin in q and k.
static inline size_t ffp_attention_stage(const FfpAttention *a, const FfpSegment *segment) {
    return segment->order * FFP_SEGMENT * (size_t)a->dim;
}
static inline FfpPacked *ffp_attention_operand(const FfpAttention *a, const FfpSegment *segment,
                                               FfpAttentionOperand part) {
    return a->packed + (segment->order * FFP_ATTENTION_OPERANDS + part) * a->part_size;
}

// A part whose lines are the segment's rows, from `row` on; and one whose lines are the head's columns and
// that has the segment's rows along k, from `row` on (a multiple of FFP_PACK_DEPTH), as B.
static inline FfpOperand ffp_flat_rows(const FfpAttention *a, const FfpSegment *segment,
                                       FfpAttentionOperand part, int row) {
    return (FfpOperand){ffp_packed_row(ffp_attention_operand(a, segment, part), row, 0, a->depth), a->depth};
}
static inline FfpOperand ffp_flat_columns(const FfpAttention *a, const FfpSegment *segment,
                                          FfpAttentionOperand part, int row) {
    return (FfpOperand){ffp_packed_column(ffp_attention_operand(a, segment, part), row, 0, a->depth),
                        a->depth};
}
static inline FfpOperand ffp_deep_columns(const FfpAttention *a, const FfpSegment *segment,
                                          FfpAttentionOperand part, int row) {
    const size_t depth = ffp_packed_depth(segment->rows);
    return (FfpOperand){ffp_packed_column(ffp_attention_operand(a, segment, part), 0, row, depth), depth};
}

#endif
