// The table of one CPU level.
#include "core/tensor/kernels/kernels.h"

const FfpKernels FFP_K(kernels) = {
    .gemm = ffp_blas_gemm,
    .gemm_mixed = FFP_K(gemm_mixed),
    .linear_forward = FFP_K(linear_forward),
    .linear_residual_forward = FFP_K(linear_residual_forward),
    .linear_backward = FFP_K(linear_backward),
    .layernorm_forward = FFP_K(layernorm_forward),
    .layernorm_backward = FFP_K(layernorm_backward),
    .rmsnorm_forward = FFP_K(rmsnorm_forward),
    .rmsnorm_backward = FFP_K(rmsnorm_backward),
    .gated_norm_forward = FFP_K(gated_norm_forward),
    .gated_norm_backward = FFP_K(gated_norm_backward),
    .add = FFP_K(add),
    .gelu_forward = FFP_K(gelu_forward),
    .gelu_backward = FFP_K(gelu_backward),
    .conv_forward = FFP_K(conv_forward),
    .conv_backward = FFP_K(conv_backward),
    .scan_scratch = FFP_K(scan_scratch),
    .scan_forward = FFP_K(scan_forward),
    .scan_backward = FFP_K(scan_backward),
    .attention_scratch = FFP_K(attention_scratch),
    .attention_forward = FFP_K(attention_forward),
    .attention_backward = FFP_K(attention_backward),
    .adam = FFP_K(adam),
    .squared_norm = ffp_plain_squared_norm,
};
