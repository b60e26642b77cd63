// Matrix products for the perceptual networks.
#ifndef FFP_CUDA_LOSS_PRODUCTS_H
#define FFP_CUDA_LOSS_PRODUCTS_H

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

// C [m,n] = op(A) B + beta C on the device; row-major, rows lda, ldb, ldc values apart. A is [m,k], or [k,m]
// when it is transposed; B [k,n]. With beta 0 what C holds is not read.
void ffp_cuda_loss_product(bool transpose_a, int m, int n, int k, const float *a, int lda, const float *b,
                           int ldb, float beta, float *c, int ldc);
// Factors are rounded to TF32 (10 bits of mantissa) unless exact products were asked for here: for tests.
void ffp_cuda_loss_exact(bool exact);

#ifdef __cplusplus
}
#endif

#endif
