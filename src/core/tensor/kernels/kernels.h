// The kernels that exist once for each CPU level (core/base/cpu.h). Every source in this folder is compiled
// once a level, with FFP_LEVEL set to the level's name and that level's instructions; FFP_K(gelu_forward) is
// then ffp_avx2_gelu_forward, and so on. core/tensor/dispatch.c picks the table of the level in use.
#ifndef FFP_TENSOR_KERNELS_KERNELS_H
#define FFP_TENSOR_KERNELS_KERNELS_H

#include "core/base/level.h"
#include "core/tensor/adam.h"
#include "core/tensor/tensor.h"

// Signatures are those of the functions in core/tensor/tensor.h and adam.h. A device (core/base/device.h) has
// such a table too.
typedef struct FfpKernels {
    __typeof__(ffp_gemm) *gemm;
    __typeof__(ffp_gemm_mixed) *gemm_mixed;
    __typeof__(ffp_linear_forward) *linear_forward;
    __typeof__(ffp_linear_residual_forward) *linear_residual_forward;
    __typeof__(ffp_linear_backward) *linear_backward;
    __typeof__(ffp_layernorm_forward) *layernorm_forward;
    __typeof__(ffp_layernorm_backward) *layernorm_backward;
    __typeof__(ffp_rmsnorm_forward) *rmsnorm_forward;
    __typeof__(ffp_rmsnorm_backward) *rmsnorm_backward;
    __typeof__(ffp_gated_norm_forward) *gated_norm_forward;
    __typeof__(ffp_gated_norm_backward) *gated_norm_backward;
    __typeof__(ffp_add) *add;
    __typeof__(ffp_gelu_forward) *gelu_forward;
    __typeof__(ffp_gelu_backward) *gelu_backward;
    __typeof__(ffp_conv_forward) *conv_forward;
    __typeof__(ffp_conv_backward) *conv_backward;
    __typeof__(ffp_scan_scratch) *scan_scratch;
    __typeof__(ffp_scan_forward) *scan_forward;
    __typeof__(ffp_scan_backward) *scan_backward;
    __typeof__(ffp_attention_scratch) *attention_scratch;
    __typeof__(ffp_attention_forward) *attention_forward;
    __typeof__(ffp_attention_backward) *attention_backward;
    __typeof__(ffp_adam) *adam;
    __typeof__(ffp_squared_norm) *squared_norm;
} FfpKernels;

#define FFP_DECLARE_KERNELS(NAME, name, ...) extern const FfpKernels ffp_##name##_kernels;
FFP_EACH_LEVEL(FFP_DECLARE_KERNELS, )

// Every CPU level's gemm, for which OpenBLAS picks its own instructions, and squared norm.
__typeof__(ffp_gemm) ffp_blas_gemm;
__typeof__(ffp_squared_norm) ffp_plain_squared_norm;

#ifdef FFP_LEVEL
__typeof__(ffp_gemm_mixed) FFP_K(gemm_mixed);
__typeof__(ffp_linear_forward) FFP_K(linear_forward);
__typeof__(ffp_linear_residual_forward) FFP_K(linear_residual_forward);
__typeof__(ffp_linear_backward) FFP_K(linear_backward);
__typeof__(ffp_layernorm_forward) FFP_K(layernorm_forward);
__typeof__(ffp_layernorm_backward) FFP_K(layernorm_backward);
__typeof__(ffp_rmsnorm_forward) FFP_K(rmsnorm_forward);
__typeof__(ffp_rmsnorm_backward) FFP_K(rmsnorm_backward);
__typeof__(ffp_gated_norm_forward) FFP_K(gated_norm_forward);
__typeof__(ffp_gated_norm_backward) FFP_K(gated_norm_backward);
__typeof__(ffp_add) FFP_K(add);
__typeof__(ffp_gelu_forward) FFP_K(gelu_forward);
__typeof__(ffp_gelu_backward) FFP_K(gelu_backward);
__typeof__(ffp_conv_forward) FFP_K(conv_forward);
__typeof__(ffp_conv_backward) FFP_K(conv_backward);
__typeof__(ffp_scan_scratch) FFP_K(scan_scratch);
__typeof__(ffp_scan_forward) FFP_K(scan_forward);
__typeof__(ffp_scan_backward) FFP_K(scan_backward);
__typeof__(ffp_attention_scratch) FFP_K(attention_scratch);
__typeof__(ffp_attention_forward) FFP_K(attention_forward);
__typeof__(ffp_attention_backward) FFP_K(attention_backward);
__typeof__(ffp_adam) FFP_K(adam);
#endif

#endif
