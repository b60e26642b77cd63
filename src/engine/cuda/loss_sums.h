// Sums over a launch in a fixed order, for the losses: every block writes what its threads have, one block
// per quantity adds that. In double, as the CPU's losses.
#ifndef FFP_CUDA_LOSS_SUMS_H
#define FFP_CUDA_LOSS_SUMS_H

#include "engine/cuda/launch.h"

enum { FFP_SUM_THREADS = 256, FFP_SUM_QUANTITIES = 2 };

// Device memory; passed to kernels by value.
typedef struct FfpPartials {
    double *total;   // [quantities], after ffp_cuda_loss_add
    double *partial; // [quantities, blocks]
    unsigned blocks;
    int quantities;
} FfpPartials;

// Scratch for a launch of so many blocks, kept from call to call: good until the next call of this.
FfpPartials ffp_cuda_loss_partials(int quantities, unsigned blocks);
void ffp_cuda_loss_add(const FfpPartials *sums);
// Waits for the totals: adds the partial sums first when `add`.
void ffp_cuda_loss_totals(double *totals, const FfpPartials *sums, bool add);
// scale * first total / count, count 0: the second total; 0 of nothing. Waits for it, unless values are taken
// late (engine/loss/table.h): keeps it then.
double ffp_cuda_mean(const FfpPartials *sums, bool add, double scale, double count);
bool ffp_cuda_losses_are_deferred(void);

// Of the table: such values, from on to off.
void ffp_cuda_losses_defer(bool on);
int ffp_cuda_deferred_count(void);
void ffp_cuda_deferred_values(double *values);

// Sum over all threads of a block of whole warps, in its thread 0; all must come.
static __device__ inline double ffp_block_sum(double mine) {
    __shared__ double of_warp[32];
    const unsigned thread = threadIdx.x + blockDim.x * (threadIdx.y + blockDim.y * threadIdx.z);
    const unsigned warps = blockDim.x * blockDim.y * blockDim.z / FFP_WARP;
    for (int by = FFP_WARP / 2; by > 0; by /= 2) mine += __shfl_down_sync(0xffffffffu, mine, by);
    __syncthreads(); // the sum before may still be read
    if (thread % FFP_WARP == 0) of_warp[thread / FFP_WARP] = mine;
    __syncthreads();
    for (unsigned w = 1; thread == 0 && w < warps; w++) mine += of_warp[w];
    return mine;
}

// The block's share of a quantity; all of its threads must come.
static __device__ inline void ffp_store_partial(FfpPartials sums, int quantity, double mine) {
    const unsigned block = blockIdx.x + gridDim.x * (blockIdx.y + gridDim.y * blockIdx.z);
    const double sum = ffp_block_sum(mine);
    if (threadIdx.x == 0 && threadIdx.y == 0 && threadIdx.z == 0)
        sums.partial[(size_t)quantity * sums.blocks + block] = sum;
}

// A thread for each of `count` elements, and their sums: the kernel takes the count, the FfpPartials, and
// whatever follows.
template <typename... P, typename... A>
FfpPartials ffp_launch_sums(int quantities, size_t count, void (*kernel)(P...), A... arguments) {
    const FfpPartials sums = ffp_cuda_loss_partials(quantities, ffp_blocks(count, FFP_SUM_THREADS));
    ffp_launch_blocks(kernel, dim3(sums.blocks), dim3(FFP_SUM_THREADS), 0, count, sums, arguments...);
    return sums;
}

#endif
