// Sums down the columns of a matrix, for the gradients of gains and biases: inside the tensor room only.
#ifndef FFP_TENSOR_COLUMNS_H
#define FFP_TENSOR_COLUMNS_H

#include <stddef.h>
#include "core/base/level.h"
#include "core/base/real.h"

// sum[dim] += sum over rows of dy * (x - mean) * rstd. x NULL counts as 1; mean
// NULL as 0, rstd NULL as 1. dy and x have dense rows of dim. A thread owns its
// columns and takes the rows in order: the same bits for any number of threads.
void FFP_K(add_column_sums)(real *sum, const real *dy, const real *x, const real *mean, const real *rstd,
                            int rows, int dim);

#endif
