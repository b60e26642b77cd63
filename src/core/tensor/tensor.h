// Kernels on plain arrays, row-major. Every *_forward has a *_backward that ADDS to gradients of parameters
// (named dw, dgain, ...) and OVERWRITES gradients of inputs (dx). T is tokens (rows), no function allocates
// unless its comment says so. All run in parallel over OpenMP threads and give the same bits for the same
// thread count. On a thread that works on a device (core/base/device.h) the arrays are the device's, scratch
// too.
#ifndef FFP_TENSOR_TENSOR_H
#define FFP_TENSOR_TENSOR_H

#include <stdbool.h>
#include <stddef.h>
#include "core/base/real.h"

// A factor of a product, a matrix of rows x columns numbers: element (i, j) is data[i * stride + j], or
// data[j * stride + i] if it is stored transposed.
typedef struct FfpFactor {
    const real *data;
    int rows, columns, stride;
    bool transposed;
} FfpFactor;
static inline FfpFactor ffp_factor(const real *data, int rows, int columns, int stride) {
    const FfpFactor factor = {data, rows, columns, stride, false};
    return factor;
}
static inline FfpFactor ffp_transposed(FfpFactor a) {
    const FfpFactor factor = {a.data, a.columns, a.rows, a.stride, !a.transposed};
    return factor;
}
// The part of it from element (row, column) on.
static inline FfpFactor ffp_factor_part(FfpFactor a, int row, int column, int rows, int columns) {
    a.data += a.transposed ? (size_t)column * a.stride + row : (size_t)row * a.stride + column;
    a.rows = rows;
    a.columns = columns;
    return a;
}

// C[m,n] = alpha A B + beta C; A is [m,k], B is [k,n], ldc is the row stride of C.
void ffp_gemm(real alpha, FfpFactor a, FfpFactor b, real beta, real *c, int ldc);

// The same with operands rounded to bf16 at the CPU levels that multiply those (core/base/cpu.h), sums in
// real. Packs them in memory of the calling thread's that is kept: allocates only for larger operands than
// ever before. C must not overlap A or B.
void ffp_gemm_mixed(real alpha, FfpFactor a, FfpFactor b, real beta, real *c, int ldc);

// Products of linear layers are ffp_gemm_mixed's.
// y[T,out] = x[T,in] w^T (+ bias[out] if not NULL); w is [out,in].
void ffp_linear_forward(real *y, const real *x, const real *w, const real *bias, int rows, int in, int out);
// y[T,out] = residual[T,out] + x[T,in] w^T; y may be the residual itself.
void ffp_linear_residual_forward(real *y, const real *residual, const real *x, const real *w, int rows,
                                 int in, int out);
// dx may be NULL (first layer); dbias may be NULL.
void ffp_linear_backward(real *dx, real *dw, real *dbias, const real *dy, const real *x, const real *w,
                         int rows, int in, int out);

// y = (x - mean) rstd * gain, eps 1e-5; mean, rstd [T] are kept for the backward pass.
void ffp_layernorm_forward(real *y, real *mean, real *rstd, const real *x, const real *gain, int rows,
                           int dim);
void ffp_layernorm_backward(real *dx, real *dgain, const real *dy, const real *x, const real *mean,
                            const real *rstd, const real *gain, int rows, int dim);

// y = x rstd * gain, rstd = 1 / sqrt(mean(x^2) + 1e-5)
void ffp_rmsnorm_forward(real *y, real *rstd, const real *x, const real *gain, int rows, int dim);
void ffp_rmsnorm_backward(real *dx, real *dgain, const real *dy, const real *x, const real *rstd,
                          const real *gain, int rows, int dim);

// Mamba2's gate: y = rmsnorm(x * silu(z)) * gain (norm after the gate). Backward recomputes.
typedef struct FfpGatedNorm {
    const real *x, *z; // [rows, dim], z with row stride ldz
    int ldz;
    const real *gain; // [dim]
    int rows, dim;
} FfpGatedNorm;
typedef struct FfpGatedNormGradient {
    real *x; // [rows, dim], overwritten
    real *z; // row stride ldz, ADDED to, because two scan directions share z
    int ldz;
    real *gain; // ADDED to
} FfpGatedNormGradient;
void ffp_gated_norm_forward(real *y, real *rstd, const FfpGatedNorm *in);
void ffp_gated_norm_backward(const FfpGatedNormGradient *grad, const FfpGatedNorm *in, const real *dy,
                             const real *rstd);

void ffp_add(real *y, const real *x, size_t count); // y += x

// Exact GELU (erf form), elementwise.
void ffp_gelu_forward(real *y, const real *x, size_t count);
void ffp_gelu_backward(real *dx, const real *dy, const real *x, size_t count);

// Depthwise causal convolution of width `taps` with bias, then SiLU: y_t = silu(b + sum_k w[c,k]
// x_{t-taps+1+k}). y is [T,channels].
enum { FFP_CONV_TAPS_MAX = 8 };
typedef struct FfpDepthwise {
    const real *x, *w, *bias; // [rows, channels] with row stride ldx, [channels, taps], [channels]
    int ldx, rows, channels, taps;
    bool reverse; // runs from the last token to the first (taps look at later tokens)
} FfpDepthwise;
typedef struct FfpDepthwiseGradient {
    real *x, *w, *bias; // ADDED to
    int ldx;
} FfpDepthwiseGradient;
void ffp_conv_forward(real *y, const FfpDepthwise *conv);
void ffp_conv_backward(const FfpDepthwiseGradient *grad, const FfpDepthwise *conv, const real *dy);

// State-space duality scan of Mamba2 (Dao & Gu 2024, Eq. 2 and Sec. 6): one direction, one B/C group.
//   dt = softplus(dt_raw + dt_bias[h]), A = -exp(a_log[h]), h_t = exp(dt A) h_{t-1} + dt x_t (outer) B_t,
//   y_t = h_t C_t + d[h] x_t
// x: [T, heads*head_dim] inside rows of stride ldx (x, B, C are slices of one convolved row); dt_raw row
// stride lddt.
typedef struct FfpScanShape {
    int rows, heads, head_dim, state, chunk;
    bool reverse;
} FfpScanShape;
typedef struct FfpScanInput {
    const real *x, *b, *c; // [T, heads*head_dim], [T, state], [T, state]; all with row stride ld
    int ld;
    const real *dt_raw; // [T, heads], row stride lddt
    int lddt;
    const real *dt_bias, *a_log, *d; // [heads]
} FfpScanInput;
typedef struct FfpScanGradient {
    real *x, *b, *c; // overwritten, row stride ld as the input's
    real *dt_raw;    // ADDED to, row stride lddt (each direction has its own slice or shares: adding is safe)
    real *dt_bias, *a_log, *d; // ADDED to
} FfpScanGradient;
// Scratch: ffp_scan_scratch(shape) reals, used by both passes, contents need not be kept between them.
size_t ffp_scan_scratch(const FfpScanShape *shape);
void ffp_scan_forward(real *y, const FfpScanShape *shape, const FfpScanInput *in,
                      real *scratch); // y [T, heads*head_dim]
void ffp_scan_backward(const FfpScanGradient *grad, const FfpScanShape *shape, const FfpScanInput *in,
                       const real *dy, real *scratch);

// Softmax attention over all T tokens, with RMS QK-norm per head. out is [T, heads*head_dim]; log_sum
// [heads,T] is kept for backward.
typedef struct FfpAttentionShape {
    int rows, heads, head_dim;
} FfpAttentionShape;
typedef struct FfpAttentionInput {
    const real *qkv;             // [T, 3*heads*head_dim]: q, k, v
    const real *q_gain, *k_gain; // [head_dim], shared by the heads
} FfpAttentionInput;
typedef struct FfpAttentionGradient {
    real *qkv;             // overwritten
    real *q_gain, *k_gain; // ADDED to
} FfpAttentionGradient;
size_t ffp_attention_scratch(const FfpAttentionShape *shape);
void ffp_attention_forward(real *out, real *log_sum, const FfpAttentionShape *shape,
                           const FfpAttentionInput *in, real *scratch);
void ffp_attention_backward(const FfpAttentionGradient *grad, const FfpAttentionShape *shape,
                            const FfpAttentionInput *in, const real *out, const real *log_sum,
                            const real *dout, real *scratch);

#endif
