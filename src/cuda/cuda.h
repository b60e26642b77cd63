// The CUDA device: kernels of the numeric rooms and of training for NVIDIA GPUs, behind the seam of
// base/device.h. Built by nvcc with FFPROCAMS_CUDA; in other builds the same sources stand behind an
// emulation on the CPU, which the tests use (launch.h).
#ifndef FFP_CUDA_CUDA_H
#define FFP_CUDA_CUDA_H

#include "base/device.h"
#include "base/error.h"

#ifdef __cplusplus
extern "C" {
#endif

// The first GPU, or the emulation. Errors: no GPU, no driver.
const FfpDevice *ffp_cuda_device(FfpError *err);
// One line on what it is: name, memory, compute capability. Static text.
const char *ffp_cuda_describe(void);

// Weak: a table that is not there is NULL (while the room is being built).
#define FFP_WEAK __attribute__((weak))
extern const struct FfpKernels ffp_cuda_tensor;
extern const struct FfpRenderTable ffp_cuda_render FFP_WEAK;
extern const struct FfpLossTable ffp_cuda_loss FFP_WEAK;
extern const struct FfpNetworkTable ffp_cuda_network FFP_WEAK;
extern const struct FfpTrainTable ffp_cuda_train FFP_WEAK;
extern const struct FfpRefineTable ffp_cuda_refine FFP_WEAK;

#ifdef __cplusplus
}
#endif

#endif
