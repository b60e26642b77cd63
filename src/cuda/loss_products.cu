// cuBLAS behind loss_products.h; in the emulation, loops.
#include "cuda/launch.h"
#include "cuda/loss_products.h"

static bool exactly;

void ffp_cuda_loss_exact(bool exact) {
    exactly = exact;
}

#ifdef __CUDACC__

#include <cublas_v2.h>

static void check(cublasStatus_t status) {
    if (status == CUBLAS_STATUS_SUCCESS) return;
    fprintf(stderr, "ffprocams: error: GPU: %s (matrix product)\n", cublasGetStatusString(status));
    abort();
}

static cublasHandle_t handle(void) {
    static cublasHandle_t kept;
    if (kept) return kept;
    check(cublasCreate(&kept));
    check(cublasSetStream(kept, ffp_cuda_stream()));
    return kept;
}

// cuBLAS counts in columns: it is asked for the transposes, C^T = B^T op(A)^T, which lie in memory as C, B
// and A do.
void ffp_cuda_loss_product(bool transpose_a, int m, int n, int k, const float *a, int lda, const float *b,
                           int ldb, float beta, float *c, int ldc) {
    const float one = 1;
    check(cublasGemmEx(handle(), CUBLAS_OP_N, transpose_a ? CUBLAS_OP_T : CUBLAS_OP_N, n, m, k, &one, b,
                       CUDA_R_32F, ldb, a, CUDA_R_32F, lda, &beta, c, CUDA_R_32F, ldc,
                       exactly ? CUBLAS_COMPUTE_32F : CUBLAS_COMPUTE_32F_FAST_TF32, CUBLAS_GEMM_DEFAULT));
}

#else

void ffp_cuda_loss_product(bool transpose_a, int m, int n, int k, const float *a, int lda, const float *b,
                           int ldb, float beta, float *c, int ldc) {
    ffp_emulated_memory(true);
    for (int i = 0; i < m; i++) {
        float *to = c + (size_t)i * ldc;
        for (int j = 0; j < n; j++) to[j] = beta == 0 ? 0 : beta * to[j];
        for (int l = 0; l < k; l++) {
            const float factor = transpose_a ? a[(size_t)l * lda + i] : a[(size_t)i * lda + l];
            const float *from = b + (size_t)l * ldb;
            for (int j = 0; j < n; j++) to[j] += factor * from[j];
        }
    }
    ffp_emulated_memory(false);
}

#endif
