// How kernels are written and started here. The same .cu sources are built twice: by nvcc for the GPU, and by
// the C++ compiler with an emulation of blocks and threads (emulate.h), so that every kernel is tested on
// machines without a GPU.
//
// A kernel is a function of __global__ type. Threads that have nothing to do with each other are started by
// ffp_launch; threads that meet (__syncthreads, shuffles, shared memory) by ffp_launch_blocks. All work of
// the program goes to one stream, in order. No sums by atomic operations on floats: the same numbers must
// come out whenever the same work is done.
#ifndef FFP_CUDA_LAUNCH_H
#define FFP_CUDA_LAUNCH_H

// Before any C header inside extern "C": these hold templates in C++.
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <tgmath.h>

#ifdef __CUDACC__

#include <cuda_runtime.h>

cudaStream_t ffp_cuda_stream(void);
// Ends the program with the error's text and `what`, unless it is a success.
void ffp_cuda_check(cudaError_t error, const char *what);

// Independent threads: none may meet another.
template <typename... P, typename... A>
static void ffp_launch(void (*kernel)(P...), dim3 grid, dim3 block, A... arguments) {
    if (grid.x == 0 || grid.y == 0 || grid.z == 0) return;
    kernel<<<grid, block, 0, ffp_cuda_stream()>>>(static_cast<P>(arguments)...);
    ffp_cuda_check(cudaGetLastError(), __PRETTY_FUNCTION__);
}

// Threads of a block may meet; `shared` bytes of dynamic shared memory (FFP_DYNAMIC_SHARED), up to 200 KB.
template <typename... P, typename... A>
static void ffp_launch_blocks(void (*kernel)(P...), dim3 grid, dim3 block, size_t shared, A... arguments) {
    if (grid.x == 0 || grid.y == 0 || grid.z == 0) return;
    if (shared > 48 * 1024)
        ffp_cuda_check(cudaFuncSetAttribute((const void *)kernel, cudaFuncAttributeMaxDynamicSharedMemorySize,
                                            (int)shared),
                       __PRETTY_FUNCTION__);
    kernel<<<grid, block, shared, ffp_cuda_stream()>>>(static_cast<P>(arguments)...);
    ffp_cuda_check(cudaGetLastError(), __PRETTY_FUNCTION__);
}

#define FFP_DYNAMIC_SHARED(type, name)                                                                       \
    extern __shared__ __align__(16) unsigned char ffp_dynamic_shared[];                                      \
    type *name = reinterpret_cast<type *>(ffp_dynamic_shared)

#else
#include "engine/cuda/emulate.h"
#endif

enum { FFP_WARP = 32 };

// Blocks of `block` threads that `count` threads need.
static inline unsigned ffp_blocks(size_t count, unsigned block) {
    return (unsigned)((count + block - 1) / block);
}

// The thread's number among all of a one-dimensional launch.
static __device__ inline size_t ffp_thread(void) {
    return (size_t)blockIdx.x * blockDim.x + threadIdx.x;
}

// One thread for each of `count` elements; the kernel's first argument is the count, and it must check
// ffp_thread() against it.
template <typename... P, typename... A>
static void ffp_launch_each(size_t count, void (*kernel)(P...), A... arguments) {
    ffp_launch(kernel, dim3(ffp_blocks(count, 256)), dim3(256), count, arguments...);
}

#endif
