// The public kernels: each goes to the table of the device that the thread works on, or of the CPU level in
// use.
#include "core/base/cpu.h"
#include "core/base/device.h"
#include "core/tensor/kernels/kernels.h"

static const FfpKernels *const tables[FFP_CPU_LEVELS] = {
    [FFP_CPU_PORTABLE] = &ffp_portable_kernels,
#if defined(FFP_ALL_LEVELS) && !defined(FFP_REAL_DOUBLE)
    [FFP_CPU_AVX2] = &ffp_avx2_kernels,
    [FFP_CPU_AVX512] = &ffp_avx512_kernels,
    [FFP_CPU_AVX512BF16] = &ffp_avx512bf16_kernels,
    [FFP_CPU_AMX] = &ffp_amx_kernels,
#endif
};

static const FfpKernels *kernels(void) {
    if (ffp_device()) return ffp_device()->tensor;
    const FfpKernels *table = tables[ffp_cpu_level()];
    return table ? table : tables[FFP_CPU_PORTABLE];
}

void ffp_gemm(real alpha, FfpFactor a, FfpFactor b, real beta, real *c, int ldc) {
    kernels()->gemm(alpha, a, b, beta, c, ldc);
}

void ffp_gemm_mixed(real alpha, FfpFactor a, FfpFactor b, real beta, real *c, int ldc) {
    kernels()->gemm_mixed(alpha, a, b, beta, c, ldc);
}

void ffp_linear_forward(real *y, const real *x, const real *w, const real *bias, int rows, int in, int out) {
    kernels()->linear_forward(y, x, w, bias, rows, in, out);
}

void ffp_linear_residual_forward(real *y, const real *residual, const real *x, const real *w, int rows,
                                 int in, int out) {
    kernels()->linear_residual_forward(y, residual, x, w, rows, in, out);
}

void ffp_linear_backward(real *dx, real *dw, real *dbias, const real *dy, const real *x, const real *w,
                         int rows, int in, int out) {
    kernels()->linear_backward(dx, dw, dbias, dy, x, w, rows, in, out);
}

void ffp_layernorm_forward(real *y, real *mean, real *rstd, const real *x, const real *gain, int rows,
                           int dim) {
    kernels()->layernorm_forward(y, mean, rstd, x, gain, rows, dim);
}

void ffp_layernorm_backward(real *dx, real *dgain, const real *dy, const real *x, const real *mean,
                            const real *rstd, const real *gain, int rows, int dim) {
    kernels()->layernorm_backward(dx, dgain, dy, x, mean, rstd, gain, rows, dim);
}

void ffp_rmsnorm_forward(real *y, real *rstd, const real *x, const real *gain, int rows, int dim) {
    kernels()->rmsnorm_forward(y, rstd, x, gain, rows, dim);
}

void ffp_rmsnorm_backward(real *dx, real *dgain, const real *dy, const real *x, const real *rstd,
                          const real *gain, int rows, int dim) {
    kernels()->rmsnorm_backward(dx, dgain, dy, x, rstd, gain, rows, dim);
}

void ffp_gated_norm_forward(real *y, real *rstd, const real *x, const real *z, int ldz, const real *gain,
                            int rows, int dim) {
    kernels()->gated_norm_forward(y, rstd, x, z, ldz, gain, rows, dim);
}

void ffp_gated_norm_backward(real *dx, real *dz, int lddz, real *dgain, const real *dy, const real *x,
                             const real *z, int ldz, const real *rstd, const real *gain, int rows, int dim) {
    kernels()->gated_norm_backward(dx, dz, lddz, dgain, dy, x, z, ldz, rstd, gain, rows, dim);
}

void ffp_add(real *y, const real *x, size_t count) {
    kernels()->add(y, x, count);
}

void ffp_gelu_forward(real *y, const real *x, size_t count) {
    kernels()->gelu_forward(y, x, count);
}

void ffp_gelu_backward(real *dx, const real *dy, const real *x, size_t count) {
    kernels()->gelu_backward(dx, dy, x, count);
}

void ffp_conv_forward(real *y, const real *x, int ldx, const real *w, const real *bias, int rows,
                      int channels, int taps, bool reverse) {
    kernels()->conv_forward(y, x, ldx, w, bias, rows, channels, taps, reverse);
}

void ffp_conv_backward(real *dx, int lddx, real *dw, real *dbias, const real *dy, const real *x, int ldx,
                       const real *w, const real *bias, int rows, int channels, int taps, bool reverse) {
    kernels()->conv_backward(dx, lddx, dw, dbias, dy, x, ldx, w, bias, rows, channels, taps, reverse);
}

size_t ffp_scan_scratch(const FfpScanShape *shape) {
    return kernels()->scan_scratch(shape);
}

void ffp_scan_forward(real *y, const FfpScanShape *shape, const FfpScanInput *in, real *scratch) {
    kernels()->scan_forward(y, shape, in, scratch);
}

void ffp_scan_backward(const FfpScanGradient *grad, const FfpScanShape *shape, const FfpScanInput *in,
                       const real *dy, real *scratch) {
    kernels()->scan_backward(grad, shape, in, dy, scratch);
}

size_t ffp_attention_scratch(int rows, int heads, int head_dim) {
    return kernels()->attention_scratch(rows, heads, head_dim);
}

void ffp_attention_forward(real *out, real *log_sum, const real *qkv, const real *q_gain, const real *k_gain,
                           int rows, int heads, int head_dim, real *scratch) {
    kernels()->attention_forward(out, log_sum, qkv, q_gain, k_gain, rows, heads, head_dim, scratch);
}

void ffp_attention_backward(real *dqkv, real *dq_gain, real *dk_gain, const real *dout, const real *out,
                            const real *log_sum, const real *qkv, const real *q_gain, const real *k_gain,
                            int rows, int heads, int head_dim, real *scratch) {
    kernels()->attention_backward(dqkv, dq_gain, dk_gain, dout, out, log_sum, qkv, q_gain, k_gain, rows,
                                  heads, head_dim, scratch);
}

void ffp_adam(const FfpAdamArray *arrays, int n) {
    kernels()->adam(arrays, n);
}

double ffp_squared_norm(const real *x, int64_t count) {
    return kernels()->squared_norm(x, count);
}
