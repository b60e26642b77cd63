// The CUDA device: kernels of the numeric rooms for NVIDIA GPUs, behind the seam of
// core/base/device.h. Built by nvcc with FFPROCAMS_CUDA; in other builds the same sources stand behind an
// emulation on the CPU, which the tests use (launch.h).
#ifndef FFP_CUDA_CUDA_H
#define FFP_CUDA_CUDA_H

#include "core/base/device.h"
#include "core/base/error.h"

#ifdef __cplusplus
extern "C" {
#endif

// The first GPU, or the emulation. Errors: no GPU, no driver.
const FfpDevice *ffp_cuda_device(FfpError *err);
// One line on what it is: name, memory, compute capability. Static text.
const char *ffp_cuda_describe(void);

// For tests: after this many further blocks of the device's memory one cannot be had. Negative: never.
void ffp_cuda_memory_ends(long long count);

extern const struct FfpKernels ffp_cuda_tensor;
extern const struct FfpImageTable ffp_cuda_image;
extern const struct FfpMatchTable ffp_cuda_match;
extern const struct FfpRenderTable ffp_cuda_render;
extern const struct FfpLossTable ffp_cuda_loss;
extern const struct FfpNetworkTable ffp_cuda_network;
extern const struct FfpRefineTable ffp_cuda_refine;

#ifdef __cplusplus
}
#endif

#endif
