// Sums down columns, for the gradients of parameters: first every block's own, then of those, both in fixed
// order.
#ifndef FFP_CUDA_COLUMNS_H
#define FFP_CUDA_COLUMNS_H

#include <stddef.h>

// Memory for partial sums, good until the next call.
float *ffp_cuda_column_partials(size_t count);

// sum1[dim1], sum2[dim2] += columns of partial [count, dim1 + dim2]. sum2 may be NULL with dim2 0.
void ffp_cuda_add_columns(const float *partial, int count, float *sum1, int dim1, float *sum2, int dim2);

// sum[dim] += columns of x [rows, dim]
void ffp_cuda_add_column_sums(float *sum, const float *x, int rows, int dim);

#endif
