// The tensor room's kernels on the GPU (core/tensor/tensor.h), one source a subject; tensor.cu has their
// table. Products take operands rounded to bf16 where the CPU's may (ffp_gemm_mixed, linear layers,
// attention) and add up in fp32; all else is fp32.
#ifndef FFP_CUDA_TENSOR_H
#define FFP_CUDA_TENSOR_H

#include "core/tensor/kernels/kernels.h"

// linear.cu
__typeof__(ffp_gemm) ffp_cuda_gemm;
__typeof__(ffp_gemm_mixed) ffp_cuda_gemm_mixed;
__typeof__(ffp_linear_forward) ffp_cuda_linear_forward;
__typeof__(ffp_linear_residual_forward) ffp_cuda_linear_residual_forward;
__typeof__(ffp_linear_backward) ffp_cuda_linear_backward;
// norm.cu
__typeof__(ffp_layernorm_forward) ffp_cuda_layernorm_forward;
__typeof__(ffp_layernorm_backward) ffp_cuda_layernorm_backward;
__typeof__(ffp_rmsnorm_forward) ffp_cuda_rmsnorm_forward;
__typeof__(ffp_rmsnorm_backward) ffp_cuda_rmsnorm_backward;
// gated_norm.cu
__typeof__(ffp_gated_norm_forward) ffp_cuda_gated_norm_forward;
__typeof__(ffp_gated_norm_backward) ffp_cuda_gated_norm_backward;
// elementwise.cu
__typeof__(ffp_add) ffp_cuda_add;
__typeof__(ffp_gelu_forward) ffp_cuda_gelu_forward;
__typeof__(ffp_gelu_backward) ffp_cuda_gelu_backward;
// depthwise.cu
__typeof__(ffp_conv_forward) ffp_cuda_conv_forward;
__typeof__(ffp_conv_backward) ffp_cuda_conv_backward;
// state_scan.cu, state_scan_backward.cu
__typeof__(ffp_scan_scratch) ffp_cuda_scan_scratch;
__typeof__(ffp_scan_forward) ffp_cuda_scan_forward;
__typeof__(ffp_scan_backward) ffp_cuda_scan_backward;
// attention.cu, attention_backward.cu
__typeof__(ffp_attention_scratch) ffp_cuda_attention_scratch;
__typeof__(ffp_attention_forward) ffp_cuda_attention_forward;
__typeof__(ffp_attention_backward) ffp_cuda_attention_backward;
// adam.cu
__typeof__(ffp_adam) ffp_cuda_adam;
__typeof__(ffp_squared_norm) ffp_cuda_squared_norm;

#endif
