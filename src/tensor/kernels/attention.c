// Softmax attention with RMS QK-norm, in blocks of queries and keys (the online softmax of Dao et al. 2022):
// no matrix of T x T is ever in memory, and the backward pass makes the probabilities anew from log_sum.
#include "tensor/kernels/kernels.h"

#include <string.h>
#include <tgmath.h>
#include "tensor/kernels/fastmath.h"

#define EPSILON 1e-5F

enum {
    QUERIES = 128, // a block of scores, QUERIES x KEYS, lives on the thread's stack: 128 KB in fp32, two in
                   // the backward
    KEYS = 256,
    SEGMENTS =
        4 // parts of the keys that the backward pass works on independently, whatever the number of threads
};

typedef struct Shape {
    int rows, heads, head_dim;
} Shape;

// Scratch. Every [heads, T, ..] array has a head's rows together.
typedef struct Layout {
    real *q, *k;      // [heads, T, head_dim], normalised; q carries the 1 / sqrt(head_dim) too
    real *inverse[2]; // [heads, T] for q and for k: 1 / root mean square
    real *delta;      // [heads, T]: dout . out
    real *dq; // [SEGMENTS, heads, T, head_dim]: gradient of the normalised q from each segment of keys
    real *dk; // [heads, T, head_dim]
    real *gain_sum[2]; // [heads, head_dim] for q and for k
} Layout;

static int smaller(int a, int b) {
    return a < b ? a : b;
}

// Sets the layout's pointers from `base` on and returns the number of reals in all.
static size_t make_layout(Layout *layout, real *base, const Shape *shape) {
    const size_t per_head = (size_t)shape->heads * (size_t)shape->rows, dim = (size_t)shape->head_dim;
    const size_t sizes[] = {per_head * dim,
                            per_head * dim,
                            per_head,
                            per_head,
                            per_head,
                            per_head * dim * SEGMENTS,
                            per_head * dim,
                            (size_t)shape->heads * dim,
                            (size_t)shape->heads * dim};
    real **parts[] = {&layout->q,  &layout->k,  &layout->inverse[0],  &layout->inverse[1], &layout->delta,
                      &layout->dq, &layout->dk, &layout->gain_sum[0], &layout->gain_sum[1]};
    size_t used = 0;
    for (size_t i = 0; i < sizeof(sizes) / sizeof(sizes[0]); i++) {
        if (base) *parts[i] = base + used;
        used += (sizes[i] + 15) / 16 * 16; // every part starts a cache line
    }
    return used;
}

size_t FFP_K(attention_scratch)(int rows, int heads, int head_dim) {
    const Shape shape = {rows, heads, head_dim};
    Layout layout;
    return make_layout(&layout, NULL, &shape);
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

static void normalise_qk(const Layout *layout, const Shape *shape, const real *qkv, const real *q_gain,
                         const real *k_gain) {
    const int dim = shape->head_dim, width = shape->heads * dim;
    const real scale = 1 / sqrt((real)dim);
#pragma omp parallel for schedule(static)
    for (int t = 0; t < shape->rows; t++) {
        const real *row = qkv + (size_t)t * 3 * width;
        for (int head = 0; head < shape->heads; head++) {
            const size_t at = (size_t)head * shape->rows + t;
            const real *q = row + (size_t)head * dim, *k = q + width;
            layout->inverse[0][at] = normalise_row(layout->q + at * dim, q, q_gain, scale, dim);
            layout->inverse[1][at] = normalise_row(layout->k + at * dim, k, k_gain, 1, dim);
        }
    }
}

// A row of scores becomes exp(score - top), top being the greatest so far; `sum` is kept up with it. Returns
// the factor that what was gathered before must be multiplied with.
static real softmax_row(real *scores, int count, real *top, real *sum) {
    real greatest = *top;
#pragma omp simd reduction(max : greatest)
    for (int i = 0; i < count; i++) greatest = scores[i] > greatest ? scores[i] : greatest;
    real added = 0;
#pragma omp simd reduction(+ : added)
    for (int i = 0; i < count; i++) {
        scores[i] = ffp_exp(scores[i] - greatest);
        added += scores[i];
    }
    const real factor = ffp_exp(*top - greatest);
    *sum = *sum * factor + added;
    *top = greatest;
    return factor;
}

// One block of queries of one head against all keys.
static void attend_block(real *out, real *log_sum, const Layout *layout, const Shape *shape, const real *qkv,
                         int head, int first, int queries) {
    const int dim = shape->head_dim, width = shape->heads * dim;
    const size_t row = (size_t)head * shape->rows;
    const real *q = layout->q + (row + first) * dim, *k = layout->k + row * dim;
    const real *v = qkv + 2 * (size_t)width + (size_t)head * dim;
    real *out_block = out + (size_t)first * width + (size_t)head * dim;
    real scores[QUERIES * KEYS], top[QUERIES], sum[QUERIES];
    for (int i = 0; i < queries; i++) top[i] = -INFINITY, sum[i] = 0;
    for (int key = 0; key < shape->rows; key += KEYS) {
        const int keys = smaller(KEYS, shape->rows - key);
        ffp_gemm(false, true, queries, keys, dim, 1, q, dim, k + (size_t)key * dim, dim, 0, scores, KEYS);
        for (int i = 0; i < queries; i++) {
            const real factor = softmax_row(scores + (size_t)i * KEYS, keys, top + i, sum + i);
            real *out_row = out_block + (size_t)i * width;
            if (key > 0)
                for (int d = 0; d < dim; d++) out_row[d] *= factor;
        }
        ffp_gemm(false, false, queries, dim, keys, 1, scores, KEYS, v + (size_t)key * 3 * width, 3 * width,
                 key > 0 ? 1 : 0, out_block, width);
    }
    for (int i = 0; i < queries; i++) {
        real *out_row = out_block + (size_t)i * width;
        const real inverse = 1 / sum[i];
        for (int d = 0; d < dim; d++) out_row[d] *= inverse;
        log_sum[row + first + i] = top[i] + log(sum[i]);
    }
}

void FFP_K(attention_forward)(real *out, real *log_sum, const real *qkv, const real *q_gain,
                              const real *k_gain, int rows, int heads, int head_dim, real *scratch) {
    const Shape shape = {rows, heads, head_dim};
    Layout layout;
    make_layout(&layout, scratch, &shape);
    normalise_qk(&layout, &shape, qkv, q_gain, k_gain);
#pragma omp parallel for collapse(2) schedule(static)
    for (int head = 0; head < heads; head++) {
        for (int first = 0; first < rows; first += QUERIES)
            attend_block(out, log_sum, &layout, &shape, qkv, head, first, smaller(QUERIES, rows - first));
    }
}

static void dot_outputs(const Layout *layout, const Shape *shape, const real *dout, const real *out) {
    const int dim = shape->head_dim, width = shape->heads * dim;
#pragma omp parallel for schedule(static)
    for (int t = 0; t < shape->rows; t++) {
        for (int head = 0; head < shape->heads; head++) {
            const size_t first = (size_t)t * width + (size_t)head * dim;
            real sum = 0;
#pragma omp simd reduction(+ : sum)
            for (int d = 0; d < dim; d++) sum += dout[first + d] * out[first + d];
            layout->delta[(size_t)head * shape->rows + t] = sum;
        }
    }
}

// scores become the probabilities P = exp(score - log_sum),
// dprobabilities become P (dP - delta), the scores' gradient.
static void score_gradients(real *scores, real *dprobabilities, const real *log_sum, const real *delta,
                            int queries, int keys) {
    for (int i = 0; i < queries; i++) {
        real *p = scores + (size_t)i * KEYS, *dp = dprobabilities + (size_t)i * KEYS;
        const real log_total = log_sum[i], centre = delta[i];
#pragma omp simd
        for (int j = 0; j < keys; j++) {
            const real probability = ffp_exp(p[j] - log_total);
            p[j] = probability;
            dp[j] = probability * (dp[j] - centre);
        }
    }
}

// All queries of one head against the keys [begin, end): their dv and dk, and these keys' part of dq.
static void attend_segment_backward(real *dqkv, const Layout *layout, const Shape *shape, const real *dout,
                                    const real *log_sum, const real *qkv, int head, int segment, int begin,
                                    int end) {
    const int dim = shape->head_dim, width = shape->heads * dim;
    const size_t row = (size_t)head * shape->rows, column = (size_t)head * dim;
    real *dq = layout->dq + ((size_t)segment * shape->heads * shape->rows + row) * dim;
    real scores[QUERIES * KEYS], dscores[QUERIES * KEYS];
    for (int key = begin; key < end; key += KEYS) {
        const int keys = smaller(KEYS, end - key);
        const size_t v_start = (size_t)key * 3 * width + 2 * (size_t)width + column;
        const real *k = layout->k + (row + key) * dim;
        real *dk = layout->dk + (row + key) * dim;
        for (int first = 0; first < shape->rows; first += QUERIES) {
            const int queries = smaller(QUERIES, shape->rows - first);
            const real *q = layout->q + (row + first) * dim,
                       *dout_block = dout + (size_t)first * width + column;
            const real fresh = first > 0 ? 1 : 0; // the first block of queries overwrites dk and dv
            ffp_gemm(false, true, queries, keys, dim, 1, q, dim, k, dim, 0, scores, KEYS);
            ffp_gemm(false, true, queries, keys, dim, 1, dout_block, width, qkv + v_start, 3 * width, 0,
                     dscores, KEYS);
            score_gradients(scores, dscores, log_sum + row + first, layout->delta + row + first, queries,
                            keys);
            ffp_gemm(true, false, keys, dim, queries, 1, scores, KEYS, dout_block, width, fresh,
                     dqkv + v_start, 3 * width);
            ffp_gemm(true, false, keys, dim, queries, 1, dscores, KEYS, q, dim, fresh, dk, dim);
            ffp_gemm(false, false, queries, dim, keys, 1, dscores, KEYS, k, dim, key > begin ? 1 : 0,
                     dq + (size_t)first * dim, dim);
        }
    }
}

// Through the RMS norm of q (which = 0) or k (1) of one head: dx = r (g - n
// mean(g n)) with n = x r, g = dy gain scale; the gain's gradient is summed over
// the head's rows. dy is summed over `parts` arrays that lie part_size apart.
static void norm_backward(real *dqkv, const Layout *layout, const Shape *shape, const real *qkv,
                          const real *gain, real *dy, int parts, real scale, int head, int which) {
    const int dim = shape->head_dim, width = shape->heads * dim;
    const size_t row = (size_t)head * shape->rows, part_size = (size_t)shape->heads * shape->rows * dim;
    real *gain_sum = layout->gain_sum[which] + (size_t)head * dim;
    memset(gain_sum, 0, sizeof(real) * (size_t)dim);
    for (int t = 0; t < shape->rows; t++) {
        const size_t at = (size_t)t * 3 * width + (size_t)which * width + (size_t)head * dim;
        const real *x = qkv + at, inverse = layout->inverse[which][row + t];
        real *dx = dqkv + at, *dy_row = dy + (row + t) * dim, along = 0;
        for (int part = 1; part < parts; part++)
            for (int d = 0; d < dim; d++) dy_row[d] += dy_row[(size_t)part * part_size + d];
#pragma omp simd reduction(+ : along)
        for (int d = 0; d < dim; d++) along += dy_row[d] * gain[d] * x[d];
        along *= inverse * inverse / (real)dim;
        for (int d = 0; d < dim; d++) {
            dx[d] = scale * inverse * (dy_row[d] * gain[d] - x[d] * along);
            gain_sum[d] += scale * inverse * dy_row[d] * x[d];
        }
    }
}

static void add_heads(real *dgain, const real *gain_sum, const Shape *shape) {
    for (int head = 0; head < shape->heads; head++)
        for (int d = 0; d < shape->head_dim; d++) dgain[d] += gain_sum[(size_t)head * shape->head_dim + d];
}

void FFP_K(attention_backward)(real *dqkv, real *dq_gain, real *dk_gain, const real *dout, const real *out,
                               const real *log_sum, const real *qkv, const real *q_gain, const real *k_gain,
                               int rows, int heads, int head_dim, real *scratch) {
    const Shape shape = {rows, heads, head_dim};
    const int segments = smaller(SEGMENTS, rows);
    const real scale = 1 / sqrt((real)head_dim);
    Layout layout;
    make_layout(&layout, scratch, &shape);
    normalise_qk(&layout, &shape, qkv, q_gain, k_gain);
    dot_outputs(&layout, &shape, dout, out);
#pragma omp parallel for collapse(2) schedule(static)
    for (int head = 0; head < heads; head++) {
        for (int segment = 0; segment < segments; segment++) {
            const int begin = (int)((long)rows * segment / segments),
                      end = (int)((long)rows * (segment + 1) / segments);
            attend_segment_backward(dqkv, &layout, &shape, dout, log_sum, qkv, head, segment, begin, end);
        }
    }
#pragma omp parallel for schedule(static)
    for (int task = 0; task < 2 * heads; task++) {
        if (task % 2 == 0)
            norm_backward(dqkv, &layout, &shape, qkv, q_gain, layout.dq, segments, scale, task / 2, 0);
        else
            norm_backward(dqkv, &layout, &shape, qkv, k_gain, layout.dk, 1, 1, task / 2, 1);
    }
    add_heads(dq_gain, layout.gain_sum[0], &shape);
    add_heads(dk_gain, layout.gain_sum[1], &shape);
}
