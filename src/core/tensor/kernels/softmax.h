// Softmax weights of a block of scores, rounded and laid out for the products that take them. Inside the
// kernels folder only. Scores are to base 2.
#ifndef FFP_TENSOR_KERNELS_SOFTMAX_H
#define FFP_TENSOR_KERNELS_SOFTMAX_H

#include "core/tensor/kernels/product.h"

// One row: weights = 2^(scores - top), zeros from `count` up to its packed depth. Returns the sum of the
// weights before rounding.
real FFP_K(softmax_row)(FfpPacked *weights, const real *scores, real top, int count);

// A block of the backward pass: rows are keys, columns queries.
typedef struct FfpSoftmaxBlock {
    int keys, queries, stride;     // stride: row stride of scores and dscores
    const real *scores, *dscores;  // K Q^T and dP^T = V dO^T
    const real *base, *delta;      // [queries]: log_sum to base 2; dout . out
    FfpPacked *weights, *dweights; // P^T and dS^T as rows of A, queries deep
    FfpPacked *columns;            // dS^T as columns of B: where number 0 of column 0 lies
    size_t columns_depth;
} FfpSoftmaxBlock;

// P = 2^(score - base) and dS = P (dP - delta). Zeros fill rows up to the packed depth of queries, and
// columns from `keys` up to its packed depth.
void FFP_K(softmax_gradients)(const FfpSoftmaxBlock *block);

#endif
