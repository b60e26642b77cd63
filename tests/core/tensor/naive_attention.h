// Attention as it is written in a book, for the tests: a whole matrix of weights for each head, sums in
// double.
#ifndef FFP_TESTS_TENSOR_NAIVE_ATTENTION_H
#define FFP_TESTS_TENSOR_NAIVE_ATTENTION_H

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include "core/base/alloc.h"
#include "core/base/real.h"

typedef struct NaiveAttention {
    double *out, *dqkv, *dq_gain, *dk_gain; // shapes as ffp_attention_backward's
} NaiveAttention;

// One head: normalised rows, weights, and the gradients of both.
typedef struct NaiveHead {
    double *q, *k, *p, *dq, *dk; // [T, dim], [T, dim], [T, T], [T, dim], [T, dim]
} NaiveHead;

static inline double root_mean_square(const real *x, int dim) {
    double sum = 0;
    for (int i = 0; i < dim; i++) sum += (double)x[i] * (double)x[i] / dim;
    return sqrt(sum + (double)1e-5F);
}

// x and y [T, dim]: y = x / rms(x) gain
static inline void naive_normalise(double *y, const real *x, size_t stride, const real *gain, int rows,
                                   int dim) {
    for (int t = 0; t < rows; t++) {
        const double size = root_mean_square(x + (size_t)t * stride, dim);
        for (int d = 0; d < dim; d++)
            y[t * dim + d] = (double)x[(size_t)t * stride + (size_t)d] / size * (double)gain[d];
    }
}

static inline void naive_weights(NaiveHead *h, int rows, int dim) {
    for (int t = 0; t < rows; t++) {
        double *p = h->p + (size_t)t * (size_t)rows, top = -INFINITY, total = 0;
        for (int s = 0; s < rows; s++) {
            p[s] = 0;
            for (int d = 0; d < dim; d++) p[s] += h->q[t * dim + d] * h->k[s * dim + d] / sqrt(dim);
            top = fmax(top, p[s]);
        }
        for (int s = 0; s < rows; s++) total += p[s] = exp(p[s] - top);
        for (int s = 0; s < rows; s++) p[s] /= total;
    }
}

// v, out, dv, dout are the head's columns of rows of 3 width, width, 3 width and width.
static inline void naive_values(NaiveHead *h, const real *v, double *out, double *dv, const real *dout,
                                int rows, int dim, size_t width) {
    for (int t = 0; t < rows; t++) {
        const double *p = h->p + (size_t)t * (size_t)rows;
        const real *g = dout + (size_t)t * width;
        double *o = out + (size_t)t * width, delta = 0;
        for (int d = 0; d < dim; d++) {
            o[d] = 0;
            for (int s = 0; s < rows; s++) o[d] += p[s] * (double)v[(size_t)s * 3 * width + (size_t)d];
            delta += o[d] * (double)g[d];
        }
        for (int s = 0; s < rows; s++) {
            double dp = 0;
            for (int d = 0; d < dim; d++) {
                dp += (double)g[d] * (double)v[(size_t)s * 3 * width + (size_t)d];
                dv[(size_t)s * 3 * width + (size_t)d] += p[s] * (double)g[d];
            }
            const double ds = p[s] * (dp - delta) / sqrt(dim);
            for (int d = 0; d < dim; d++) {
                h->dq[t * dim + d] += ds * h->k[s * dim + d];
                h->dk[s * dim + d] += ds * h->q[t * dim + d];
            }
        }
    }
}

// dx [T] rows of `stride`, through y = x / rms(x) gain; adds to dgain.
static inline void naive_norm_backward(double *dx, double *dgain, const double *dy, const real *x,
                                       size_t stride, const real *gain, int rows, int dim) {
    for (int t = 0; t < rows; t++) {
        const real *row = x + (size_t)t * stride;
        const double size = root_mean_square(row, dim);
        double along = 0;
        for (int d = 0; d < dim; d++) {
            along += dy[t * dim + d] * (double)gain[d] * (double)row[d] / (size * size * dim);
            dgain[d] += dy[t * dim + d] * (double)row[d] / size;
        }
        for (int d = 0; d < dim; d++)
            dx[(size_t)t * stride + (size_t)d] =
                (dy[t * dim + d] * (double)gain[d] - along * (double)row[d]) / size;
    }
}

// Release with free_naive_attention.
static inline NaiveAttention naive_attention(const real *dout, const real *qkv, const real *q_gain,
                                             const real *k_gain, int rows, int heads, int dim) {
    const size_t width = (size_t)heads * (size_t)dim, count = (size_t)rows * width, size = sizeof(double);
    NaiveAttention n = {ffp_alloc(count, size), ffp_alloc(3 * count, size), ffp_alloc((size_t)dim, size),
                        ffp_alloc((size_t)dim, size)};
    for (int head = 0; head < heads; head++) {
        const size_t all = (size_t)rows * (size_t)dim, first = (size_t)head * (size_t)dim;
        NaiveHead h = {ffp_alloc(all, size), ffp_alloc(all, size),
                       ffp_alloc((size_t)rows * (size_t)rows, size), ffp_alloc(all, size),
                       ffp_alloc(all, size)};
        const real *q = qkv + first, *k = q + width;
        naive_normalise(h.q, q, 3 * width, q_gain, rows, dim);
        naive_normalise(h.k, k, 3 * width, k_gain, rows, dim);
        naive_weights(&h, rows, dim);
        naive_values(&h, k + width, n.out + first, n.dqkv + 2 * width + first, dout + first, rows, dim,
                     width);
        naive_norm_backward(n.dqkv + first, n.dq_gain, h.dq, q, 3 * width, q_gain, rows, dim);
        naive_norm_backward(n.dqkv + width + first, n.dk_gain, h.dk, k, 3 * width, k_gain, rows, dim);
        ffp_free(h.q), ffp_free(h.k), ffp_free(h.p), ffp_free(h.dq), ffp_free(h.dk);
    }
    return n;
}

static inline void free_naive_attention(NaiveAttention *n) {
    ffp_free(n->out), ffp_free(n->dqkv), ffp_free(n->dq_gain), ffp_free(n->dk_gain);
}

#endif
