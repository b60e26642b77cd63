#include "core/tensor/kernels/attention_parts.h"
#include <tgmath.h>
#include "core/tensor/kernels/exp2.h"

#define EPSILON 1e-5F

// Everything but the pointers into the scratch.
static FfpAttention make_shape(const FfpAttentionShape *shape) {
    const int dim = shape->head_dim;
    FfpAttention a = {.rows = shape->rows, .heads = shape->heads, .dim = dim, .width = shape->heads * dim};
    a.segments = (shape->rows + FFP_SEGMENT - 1) / FFP_SEGMENT;
    a.depth = ffp_packed_depth(dim);
    const size_t flat = ffp_packed_size(FFP_SEGMENT, dim), deep = ffp_packed_size(dim, FFP_SEGMENT);
    a.part_size = flat > deep ? flat : deep;
    return a;
}

// Sizes in reals, in the order of FfpAttention.
enum { PARTS = 9 };
static void part_sizes(size_t sizes[PARTS], const FfpAttention *a) {
    const size_t heads = (size_t)a->heads, segments = heads * (size_t)a->segments;
    const size_t per_row = heads * (size_t)a->rows, dim = (size_t)a->dim,
                 stage = segments * FFP_SEGMENT * dim;
    const size_t packed = segments * FFP_ATTENTION_OPERANDS * a->part_size * sizeof(FfpPacked) / sizeof(real);
    const size_t parts[PARTS] = {stage,   stage,          per_row,        per_row, per_row,
                                 per_row, segments * dim, segments * dim, packed};
    for (int i = 0; i < PARTS; i++) sizes[i] = (parts[i] + 15) / 16 * 16; // every part starts a cache line
}

size_t FFP_K(attention_scratch)(const FfpAttentionShape *shape) {
    const FfpAttention a = make_shape(shape);
    size_t sizes[PARTS], sum = 0;
    part_sizes(sizes, &a);
    for (int i = 0; i < PARTS; i++) sum += sizes[i];
    return sum;
}

FfpAttention FFP_K(attention_layout)(const FfpAttentionShape *shape, real *scratch) {
    FfpAttention a = make_shape(shape);
    size_t sizes[PARTS];
    part_sizes(sizes, &a);
    real **parts[PARTS - 1] = {&a.q,    &a.k,     &a.inverse[0],  &a.inverse[1],
                               &a.base, &a.delta, &a.gain_sum[0], &a.gain_sum[1]};
    for (int i = 0; i < PARTS - 1; i++) {
        *parts[i] = scratch;
        scratch += sizes[i];
    }
    a.packed = (FfpPacked *)scratch;
    return a;
}

FfpSegment FFP_K(attention_segment)(const FfpAttention *a, int head, int index) {
    FfpSegment segment = {.head = head, .index = index, .first = index * FFP_SEGMENT};
    segment.rows = ffp_smaller(FFP_SEGMENT, a->rows - segment.first);
    segment.order = (size_t)head * (size_t)a->segments + (size_t)index;
    return segment;
}

// out = x / rms(x) * gain * scale
static real normalise_row(real *out, const real *x, const real *gain, real scale, int dim) {
    real sum = 0;
#pragma omp simd reduction(+ : sum)
    for (int i = 0; i < dim; i++) sum += x[i] * x[i];
    const real inverse = 1 / sqrt(sum / (real)dim + EPSILON);
    for (int i = 0; i < dim; i++) out[i] = x[i] * inverse * gain[i] * scale;
    return inverse;
}

// A head's rows lie far apart: the cache is told of q, k and v some rows before they are needed.
enum { ROWS_AHEAD = 4, NUMBERS_A_LINE = 64 / sizeof(real) };

static void fetch_row(const FfpAttention *a, const real *q) {
    for (int part = 0; part < 3; part++)
        for (int d = 0; d < a->dim; d += NUMBERS_A_LINE) __builtin_prefetch(q + (size_t)part * a->width + d);
}

void FFP_K(attention_normalise)(const FfpAttention *a, const FfpSegment *segment,
                                const FfpAttentionInput *in) {
    const int dim = a->dim;
    const real scale = (real)FFP_LOG2_E / sqrt((real)dim);
    const size_t stage = ffp_attention_stage(a, segment);
    for (int i = 0; i < segment->rows; i++) {
        const real *q = in->qkv + (size_t)(segment->first + i) * 3 * a->width + (size_t)segment->head * dim;
        if (i + ROWS_AHEAD < segment->rows) fetch_row(a, q + (size_t)ROWS_AHEAD * 3 * a->width);
        const size_t at = (size_t)segment->head * a->rows + segment->first + i, row = stage + (size_t)i * dim;
        a->inverse[0][at] = normalise_row(a->q + row, q, in->q_gain, scale, dim);
        a->inverse[1][at] = normalise_row(a->k + row, q + a->width, in->k_gain, 1, dim);
    }
}
