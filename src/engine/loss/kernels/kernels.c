// The table of one CPU level.
#include "engine/loss/kernels/kernels.h"

const FfpLossKernels FFP_K(loss) = {
    .blur_moments = FFP_K(ssim_moments),
    .compare = FFP_K(ssim_compare),
    .add_gradient = FFP_K(ssim_gradient),
    .conv2d_forward = FFP_K(conv2d_forward),
    .conv2d_backward = FFP_K(conv2d_backward),
    .maxpool_forward = FFP_K(maxpool_forward),
    .maxpool_backward = FFP_K(maxpool_backward),
};
