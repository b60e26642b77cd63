// The table of the tensor room's kernels.
#include "engine/cuda/launch.h"
extern "C" {
#include "engine/cuda/cuda.h"
#include "engine/cuda/tensor.h"
}

extern "C" const struct FfpKernels ffp_cuda_tensor = {
    .gemm = ffp_cuda_gemm,
    .gemm_mixed = ffp_cuda_gemm_mixed,
    .linear_forward = ffp_cuda_linear_forward,
    .linear_residual_forward = ffp_cuda_linear_residual_forward,
    .linear_backward = ffp_cuda_linear_backward,
    .layernorm_forward = ffp_cuda_layernorm_forward,
    .layernorm_backward = ffp_cuda_layernorm_backward,
    .rmsnorm_forward = ffp_cuda_rmsnorm_forward,
    .rmsnorm_backward = ffp_cuda_rmsnorm_backward,
    .gated_norm_forward = ffp_cuda_gated_norm_forward,
    .gated_norm_backward = ffp_cuda_gated_norm_backward,
    .add = ffp_cuda_add,
    .gelu_forward = ffp_cuda_gelu_forward,
    .gelu_backward = ffp_cuda_gelu_backward,
    .conv_forward = ffp_cuda_conv_forward,
    .conv_backward = ffp_cuda_conv_backward,
    .scan_scratch = ffp_cuda_scan_scratch,
    .scan_forward = ffp_cuda_scan_forward,
    .scan_backward = ffp_cuda_scan_backward,
    .attention_scratch = ffp_cuda_attention_scratch,
    .attention_forward = ffp_cuda_attention_forward,
    .attention_backward = ffp_cuda_attention_backward,
    .adam = ffp_cuda_adam,
    .squared_norm = ffp_cuda_squared_norm,
};
