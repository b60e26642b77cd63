#include "engine/cuda/launch.h"
#include "engine/cuda/products.h"

#ifdef __CUDACC__

#include <cublas_v2.h>

static void check(cublasStatus_t status, const char *what) {
    if (status == CUBLAS_STATUS_SUCCESS) return;
    fprintf(stderr, "ffprocams: error: GPU: %s (%s)\n", cublasGetStatusString(status), what);
    abort();
}

static cublasHandle_t handle(void) {
    static cublasHandle_t made;
    if (made) return made;
    check(cublasCreate(&made), "cuBLAS");
    check(cublasSetStream(made, ffp_cuda_stream()), "cuBLAS");
    return made;
}

// cuBLAS is column-major, where a row-major matrix is its transpose: C^T = op(B)^T op(A)^T.
void ffp_cuda_product(const FfpCudaProduct *p) {
    if (p->m <= 0 || p->n <= 0) return;
    const cudaDataType_t type = p->operands == FFP_OPERANDS_BF16 ? CUDA_R_16BF : CUDA_R_32F;
    const cublasComputeType_t compute =
        p->operands == FFP_OPERANDS_TF32 ? CUBLAS_COMPUTE_32F_FAST_TF32 : CUBLAS_COMPUTE_32F;
    const cublasOperation_t first = p->b.transposed ? CUBLAS_OP_T : CUBLAS_OP_N;
    const cublasOperation_t second = p->a.transposed ? CUBLAS_OP_T : CUBLAS_OP_N;
    check(cublasGemmEx(handle(), first, second, p->n, p->m, p->k, &p->alpha, p->b.data, type, p->b.ld,
                       p->a.data, type, p->a.ld, &p->beta, p->c, CUDA_R_32F, p->ldc, compute,
                       CUBLAS_GEMM_DEFAULT),
          "product");
}

#else

static float number(const void *matrix, FfpCudaOperands operands, size_t at) {
    if (operands == FFP_OPERANDS_BF16) return __uint_as_float((unsigned)((const uint16_t *)matrix)[at] << 16);
    const float x = ((const float *)matrix)[at];
    if (operands == FFP_OPERANDS_F32) return x;
    const unsigned bits = __float_as_uint(x);
    return __uint_as_float((bits + 0x1000U) & ~0x1fffU); // to the nearest, as the hardware's conversion does
}

void ffp_cuda_product(const FfpCudaProduct *p) {
    ffp_emulated_memory(true);
    for (int i = 0; i < p->m; i++) {
        float *c = p->c + (size_t)i * p->ldc;
        for (int j = 0; j < p->n; j++) c[j] = p->beta == 0 ? 0 : p->beta * c[j];
        for (int k = 0; k < p->k; k++) {
            const size_t at = p->a.transposed ? (size_t)k * p->a.ld + i : (size_t)i * p->a.ld + k;
            const float factor = p->alpha * number(p->a.data, p->operands, at);
            for (int j = 0; j < p->n; j++) {
                const size_t from = p->b.transposed ? (size_t)j * p->b.ld + k : (size_t)k * p->b.ld + j;
                c[j] += factor * number(p->b.data, p->operands, from);
            }
        }
    }
    ffp_emulated_memory(false);
}

#endif

void ffp_cuda_multiply(FfpCudaOperands operands, float alpha, FfpFactor a, FfpFactor b, float beta, float *c,
                       int ldc) {
    const FfpCudaProduct product = {.operands = operands,
                                    .m = a.rows,
                                    .n = b.columns,
                                    .k = a.columns,
                                    .alpha = alpha,
                                    .a = {a.data, a.stride, a.transposed},
                                    .b = {b.data, b.stride, b.transposed},
                                    .beta = beta,
                                    .c = c,
                                    .ldc = ldc};
    ffp_cuda_product(&product);
}
