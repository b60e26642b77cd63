// Attention as it is written in a book, for the tests: one
// query after another, all scores in a row, sums in double.
#ifndef FFP_TESTS_TENSOR_NAIVE_ATTENTION_H
#define FFP_TESTS_TENSOR_NAIVE_ATTENTION_H

#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include "base/real.h"

static inline double root_mean_square(const real *x, int dim) {
    double sum = 0;
    for (int i = 0; i < dim; i++) sum += (double)x[i] * (double)x[i] / dim;
    return sqrt(sum + (double)1e-5F);
}

static inline void naive_attention(real *out, const real *qkv, const real *q_gain, const real *k_gain,
                                   int rows, int heads, int dim) {
    const size_t width = (size_t)heads * (size_t)dim;
    double *p = malloc(sizeof(double) * (size_t)rows);
    for (int t = 0; t < rows; t++) {
        for (int head = 0; head < heads; head++) {
            const real *q = qkv + (size_t)t * 3 * width + (size_t)head * (size_t)dim;
            double total = 0;
            for (int s = 0; s < rows; s++) {
                const real *k = qkv + ((size_t)s * 3 + 1) * width + (size_t)head * (size_t)dim;
                double score = 0;
                for (int d = 0; d < dim; d++)
                    score += (double)q[d] * (double)q_gain[d] * (double)k[d] * (double)k_gain[d];
                p[s] = exp(score / (root_mean_square(q, dim) * root_mean_square(k, dim) * sqrt(dim)));
                total += p[s];
            }
            for (int d = 0; d < dim; d++) {
                double sum = 0;
                for (int s = 0; s < rows; s++)
                    sum += p[s] *
                           (double)qkv[((size_t)s * 3 + 2) * width + (size_t)head * (size_t)dim + (size_t)d];
                out[(size_t)t * width + (size_t)head * (size_t)dim + (size_t)d] = (real)(sum / total);
            }
        }
    }
    free(p);
}

#endif
