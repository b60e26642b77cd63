// Functions that the sources of the losses on the GPU offer to their table (loss.cu). See
// engine/loss/table.h.
#ifndef FFP_CUDA_LOSS_ROOM_H
#define FFP_CUDA_LOSS_ROOM_H

extern "C" {
#include "core/image/table.h"
#include "engine/loss/table.h"
}

// loss_pixels.cu
real ffp_cuda_l1(const FfpImage *prediction, const FfpImage *target, real weight, FfpImage *grad);
real ffp_cuda_square(const FfpImage *prediction, const FfpImage *target, real weight, FfpImage *grad);
double ffp_cuda_squared_error(const FfpImage *a, const FfpImage *b, const FfpImage *mask, size_t *count);
void ffp_cuda_to_srgb(FfpImage *image);
void ffp_cuda_to_linear(FfpImage *image);

// loss_ssim.cu
double ffp_cuda_ssim(const FfpImage *a, const FfpImage *b, real scale, FfpImage *grad);

// loss_maps.cu
real ffp_cuda_mask(const real *opacity, const real *mask, int pixels, real weight, real *grad_opacity);
real ffp_cuda_depth(const real *depth_sum, const real *opacity, const real *truth, int pixels, real weight,
                    real *grad_depth_sum, real *grad_opacity);
real ffp_cuda_distortion(const real *distortion, int pixels, real weight, real *grad_distortion);
double ffp_cuda_truth(const real *sum, const real *opacity, const FfpImage *truth, const FfpImage *coverage,
                      real weight, real *grad);
double ffp_cuda_distance(const real *t, const real *truth, int64_t count, real weight, real *grad);

// loss_smooth.cu
real ffp_cuda_normal_smooth(const real *normal_sum, const real *mask, int width, int height, real weight,
                            real *grad);
real ffp_cuda_roughness(const real *roughness_sum, const real *albedo_sum, const real *opacity,
                        const real *mask, int width, int height, real weight, real *grad_roughness_sum,
                        real *grad_opacity);

// perceptual.cu
void *ffp_cuda_perceptual_upload(const FfpPerceptual *net);
void ffp_cuda_perceptual_release(void *weights);
real ffp_cuda_perceptual(const FfpPerceptual *net, const void *weights, const FfpImage *prediction,
                         const FfpImage *target, real weight, FfpImage *grad);

#endif
