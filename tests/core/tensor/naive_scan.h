// The SSD scan's plain recurrence and its backward pass in
// double, for one head after another: what fp32 is held against.
#ifndef FFP_TESTS_TENSOR_NAIVE_SCAN_H
#define FFP_TESTS_TENSOR_NAIVE_SCAN_H

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/tensor/tensor.h"

typedef struct NaiveScan {
    double *y, *x, *b, *c,
        *dt_raw; // dense: [T, heads*head_dim], gradients of the same, [T, state] twice, [T, heads]
    double *dt_bias, *a_log, *d;    // [heads]
    double *bias_size, *a_log_size; // [heads]: sums over the rows of the magnitudes of their terms
} NaiveScan;

static inline NaiveScan new_naive_scan(const FfpScanShape *s) {
    const size_t rows = (size_t)s->rows, heads = (size_t)s->heads, width = heads * (size_t)s->head_dim;
    const size_t state = (size_t)s->state, size = sizeof(double);
    return (NaiveScan){ffp_alloc(rows * width, size), ffp_alloc(rows * width, size),
                       ffp_alloc(rows * state, size), ffp_alloc(rows * state, size),
                       ffp_alloc(rows * heads, size), ffp_alloc(heads, size),
                       ffp_alloc(heads, size),        ffp_alloc(heads, size),
                       ffp_alloc(heads, size),        ffp_alloc(heads, size)};
}

static inline void free_naive_scan(NaiveScan *n) {
    double *all[] = {n->y,       n->x,     n->b, n->c,         n->dt_raw,
                     n->dt_bias, n->a_log, n->d, n->bias_size, n->a_log_size};
    for (size_t i = 0; i < sizeof(all) / sizeof(all[0]); i++) ffp_free(all[i]);
}

// One step of the recurrence, forward (into n->y and states[i+1])
// or backward (from g, the gradient of states[i+1]).
static inline void naive_scan_step(NaiveScan *n, const FfpScanShape *s, const FfpScanInput *in,
                                   const real *dy, double *states, double *g, int head, int i, int backward) {
    const int t = s->reverse ? s->rows - 1 - i : i, size = s->head_dim * s->state,
              width = s->heads * s->head_dim;
    const real *x = in->x + (size_t)t * (size_t)in->ld + head * s->head_dim;
    const real *b = in->b + (size_t)t * (size_t)in->ld, *c = in->c + (size_t)t * (size_t)in->ld;
    const double raw = (double)in->dt_raw[t * in->lddt + head] + (double)in->dt_bias[head];
    const double dt = log1p(exp(raw)), rate = -exp((double)in->a_log[head]), decay = exp(dt * rate);
    double *before = states + (size_t)i * (size_t)size, *after = before + size;
    double decay_grad = 0, x_grad_dot = 0;
    for (int p = 0; p < s->head_dim; p++) {
        const size_t out = (size_t)t * (size_t)width + (size_t)(head * s->head_dim + p);
        const double dout = backward ? (double)dy[out] : 0;
        double dx = 0;
        if (!backward) n->y[out] = (double)in->d[head] * (double)x[p];
        for (int k = 0; k < s->state; k++) {
            const int e = p * s->state + k;
            if (!backward) {
                after[e] = decay * before[e] + dt * (double)x[p] * (double)b[k];
                n->y[out] += after[e] * (double)c[k];
                continue;
            }
            g[e] += dout * (double)c[k];
            n->c[t * s->state + k] += dout * after[e];
            n->b[t * s->state + k] += g[e] * dt * (double)x[p];
            dx += g[e] * (double)b[k];
            decay_grad += g[e] * before[e];
            g[e] *= decay;
        }
        n->x[out] += dt * dx + (double)in->d[head] * dout;
        n->d[head] += dout * (double)x[p];
        x_grad_dot += dx * (double)x[p];
    }
    if (!backward) return;
    const double draw = (rate * decay_grad * decay + x_grad_dot) / (1 + exp(-raw));
    n->dt_raw[t * s->heads + head] = draw;
    n->dt_bias[head] += draw;
    n->a_log[head] += rate * dt * decay_grad * decay;
    n->bias_size[head] += fabs(draw);
    n->a_log_size[head] += fabs(rate * dt * decay_grad * decay);
}

static inline void naive_scan(NaiveScan *n, const FfpScanShape *s, const FfpScanInput *in, const real *dy) {
    const size_t size = (size_t)s->head_dim * (size_t)s->state;
    double *states = ffp_alloc(((size_t)s->rows + 1) * size, sizeof(double)),
           *g = ffp_alloc(size, sizeof(double));
    for (int head = 0; head < s->heads; head++) {
        memset(g, 0, size * sizeof(double));
        for (int i = 0; i < s->rows; i++) naive_scan_step(n, s, in, dy, states, g, head, i, 0);
        for (int i = s->rows - 1; i >= 0; i--) naive_scan_step(n, s, in, dy, states, g, head, i, 1);
    }
    ffp_free(states), ffp_free(g);
}

#endif
