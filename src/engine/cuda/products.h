// Matrix products on the GPU, by cuBLAS. All matrices are row-major.
#ifndef FFP_CUDA_PRODUCTS_H
#define FFP_CUDA_PRODUCTS_H

#ifdef __cplusplus
extern "C" {
#endif
#include "core/tensor/tensor.h"

// The operands' type, as stored or rounded to. Sums and C are fp32.
typedef enum FfpCudaOperands {
    FFP_OPERANDS_F32,
    FFP_OPERANDS_TF32, // fp32 numbers, of whose 23 bits of mantissa 10 are used: up to 8 times as fast
    FFP_OPERANDS_BF16
} FfpCudaOperands;

// ld: numbers from one row to the next.
typedef struct FfpCudaOperand {
    const void *data;
    int ld;
    bool transposed;
} FfpCudaOperand;

// C[m,n] = alpha op(A) op(B) + beta C, as ffp_gemm. C is not read where beta is 0. bf16
// products are fast where rows start at multiples of 16 bytes.
typedef struct FfpCudaProduct {
    FfpCudaOperands operands;
    int m, n, k;
    float alpha;
    FfpCudaOperand a, b;
    float beta;
    float *c;
    int ldc;
} FfpCudaProduct;

void ffp_cuda_product(const FfpCudaProduct *product);
// One product of fp32 numbers, as FFP_OPERANDS_F32 or FFP_OPERANDS_TF32: C = alpha A B + beta C.
void ffp_cuda_multiply(FfpCudaOperands operands, float alpha, FfpFactor a, FfpFactor b, float beta, float *c,
                       int ldc);
#ifdef __cplusplus
}
#endif

#endif
