// The losses' table.
#include "engine/cuda/loss_sums.h"
extern "C" {
#include "engine/cuda/cuda.h"
}
#include "engine/cuda/loss_room.h"

extern "C" const struct FfpImageTable ffp_cuda_image = {
    .to_srgb = ffp_cuda_to_srgb,
    .to_linear = ffp_cuda_to_linear,
};

extern "C" const struct FfpLossTable ffp_cuda_loss = {
    .l1 = ffp_cuda_l1,
    .square = ffp_cuda_square,
    .ssim = ffp_cuda_ssim,
    .mask = ffp_cuda_mask,
    .depth = ffp_cuda_depth,
    .distortion = ffp_cuda_distortion,
    .truth = ffp_cuda_truth,
    .distance = ffp_cuda_distance,
    .normal_smooth = ffp_cuda_normal_smooth,
    .roughness = ffp_cuda_roughness,
    .squared_error = ffp_cuda_squared_error,
    .late = ffp_cuda_losses_defer,
    .deferred_count = ffp_cuda_deferred_count,
    .deferred_values = ffp_cuda_deferred_values,
    .perceptual_upload = ffp_cuda_perceptual_upload,
    .perceptual_release = ffp_cuda_perceptual_release,
    .perceptual = ffp_cuda_perceptual,
};
