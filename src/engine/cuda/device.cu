// The GPU as a device (core/base/device.h).
#include <stdio.h>
extern "C" {
#include "engine/cuda/cuda.h"
}
#include "engine/cuda/launch.h"
#include "engine/cuda/memory.h"

static const FfpDevice device = {
    .name = "cuda",
    .alloc = ffp_cuda_try_alloc,
    .release = ffp_cuda_release,
    .upload = ffp_cuda_upload,
    .download = ffp_cuda_download,
    .copy = ffp_cuda_copy,
    .zero = ffp_cuda_zero,
    .synchronise = ffp_cuda_synchronise,
    .tensor = &ffp_cuda_tensor,
    .image = &ffp_cuda_image,
    .match = &ffp_cuda_match,
    .render = &ffp_cuda_render,
    .loss = &ffp_cuda_loss,
    .network = &ffp_cuda_network,
    .refine = &ffp_cuda_refine,
};

#ifdef __CUDACC__

const FfpDevice *ffp_cuda_device(FfpError *err) {
    int count = 0;
    const cudaError_t error = cudaGetDeviceCount(&count);
    if (error != cudaSuccess || count < 1) {
        ffp_fail(err, FFP_ERROR_UNSUPPORTED, "cuda", "no GPU: %s",
                 error ? cudaGetErrorString(error) : "none found");
        return NULL;
    }
    return &device;
}

const char *ffp_cuda_describe(void) {
    static char text[768];
    cudaDeviceProp p;
    ffp_cuda_check(cudaGetDeviceProperties(&p, 0), "properties");
    snprintf(text, sizeof text, "%s, %.0f GB, compute capability %d.%d, %d multiprocessors", p.name,
             (double)p.totalGlobalMem / 1e9, p.major, p.minor, p.multiProcessorCount);
    return text;
}

#else

const FfpDevice *ffp_cuda_device(FfpError *err) {
    (void)err;
    return &device;
}

const char *ffp_cuda_describe(void) {
    return "emulated on the CPU";
}

#endif
