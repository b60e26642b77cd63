// The public kernels: each goes to the table of the device that the thread works on, or of the CPU level in
// use.
#include "core/base/cpu.h"
#include "core/base/device.h"
#include "core/tensor/kernels/kernels.h"

static const FfpKernels *const tables[FFP_CPU_LEVELS] = {
#ifdef FFP_REAL_DOUBLE
    [FFP_CPU_PORTABLE] = &ffp_portable_kernels,
#else
#define ENTRY(NAME, name, ...) [FFP_CPU_##NAME] = &ffp_##name##_kernels,
    FFP_EACH_LEVEL(ENTRY, )
#endif
};

static const FfpKernels *kernels(void) {
    if (ffp_device()) return ffp_device()->tensor;
    const FfpKernels *table = tables[ffp_cpu_level()];
    return table ? table : tables[0]; // in double there is no other
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

void ffp_gated_norm_forward(real *y, real *rstd, const FfpGatedNorm *in) {
    kernels()->gated_norm_forward(y, rstd, in);
}

void ffp_gated_norm_backward(const FfpGatedNormGradient *grad, const FfpGatedNorm *in, const real *dy,
                             const real *rstd) {
    kernels()->gated_norm_backward(grad, in, dy, rstd);
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

void ffp_conv_forward(real *y, const FfpDepthwise *conv) {
    kernels()->conv_forward(y, conv);
}

void ffp_conv_backward(const FfpDepthwiseGradient *grad, const FfpDepthwise *conv, const real *dy) {
    kernels()->conv_backward(grad, conv, dy);
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

size_t ffp_attention_scratch(const FfpAttentionShape *shape) {
    return kernels()->attention_scratch(shape);
}

void ffp_attention_forward(real *out, real *log_sum, const FfpAttentionShape *shape,
                           const FfpAttentionInput *in, real *scratch) {
    kernels()->attention_forward(out, log_sum, shape, in, scratch);
}

void ffp_attention_backward(const FfpAttentionGradient *grad, const FfpAttentionShape *shape,
                            const FfpAttentionInput *in, const real *out, const real *log_sum,
                            const real *dout, real *scratch) {
    kernels()->attention_backward(grad, shape, in, out, log_sum, dout, scratch);
}

void ffp_adam(const FfpAdamArray *arrays, int n) {
    kernels()->adam(arrays, n);
}

double ffp_squared_norm(const real *x, int64_t count) {
    return kernels()->squared_norm(x, count);
}
