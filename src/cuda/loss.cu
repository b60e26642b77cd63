// The losses' table, and how their kernels' sums are added.
#include "cuda/loss_sums.h"
#include "cuda/memory.h"
extern "C" {
#include "cuda/cuda.h"
}
#include "cuda/loss_room.h"

extern "C" const struct FfpImageTable ffp_cuda_image = {
    .to_srgb = ffp_cuda_to_srgb,
    .to_linear = ffp_cuda_to_linear,
};

extern "C" const struct FfpLossTable ffp_cuda_loss = {
    .l1 = ffp_cuda_l1,
    .ssim = ffp_cuda_ssim,
    .srgb_encode_backward = ffp_cuda_srgb_encode_backward,
    .mask = ffp_cuda_mask,
    .depth = ffp_cuda_depth,
    .distortion = ffp_cuda_distortion,
    .normal_smooth = ffp_cuda_normal_smooth,
    .roughness = ffp_cuda_roughness,
    .squared_error = ffp_cuda_squared_error,
    .perceptual_upload = ffp_cuda_perceptual_upload,
    .perceptual_release = ffp_cuda_perceptual_release,
    .perceptual = ffp_cuda_perceptual,
};

FfpPartials ffp_cuda_loss_partials(int quantities, unsigned blocks) {
    static void *scratch;
    static size_t capacity;
    ffp_cuda_grow(&scratch, &capacity, (FFP_SUM_QUANTITIES + (size_t)quantities * blocks) * sizeof(double));
    double *total = (double *)scratch;
    return FfpPartials{total, total + FFP_SUM_QUANTITIES, blocks, quantities};
}

static __global__ void add_partials(FfpPartials sums) {
    const double *partial = sums.partial + (size_t)blockIdx.x * sums.blocks;
    double mine = 0;
    for (unsigned i = threadIdx.x; i < sums.blocks; i += blockDim.x) mine += partial[i];
    mine = ffp_block_sum(mine);
    if (threadIdx.x == 0) sums.total[blockIdx.x] = mine;
}

void ffp_cuda_loss_add(const FfpPartials *sums) {
    ffp_launch_blocks(add_partials, dim3((unsigned)sums->quantities), dim3(FFP_SUM_THREADS), 0, *sums);
}

void ffp_cuda_loss_totals(double *totals, const FfpPartials *sums, bool add) {
    if (add) ffp_cuda_loss_add(sums);
    ffp_cuda_download(totals, sums->total, (size_t)sums->quantities * sizeof *totals);
}
