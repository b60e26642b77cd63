// Gradients of a picture's loss with respect to where its two devices stand and look, and how far they zoom.
// On the CPU alone.
#ifndef FFP_RENDER_AIM_H
#define FFP_RENDER_AIM_H

#include "engine/render/render.h"

// A pose's gradient is that of xi in exp(xi) pose at xi = 0 (device to world, perturbed from the left, in
// world units and radians): three numbers of the translation, then three of the rotation. Focal lengths: fx,
// fy, in pixels of the device.
typedef struct FfpAimGradient {
    double camera[6], projector[6], camera_focal[2], projector_focal[2];
} FfpAimGradient;

// ADDS what the light of a view gives: by the surface point, which the camera's ray carries with it, by the
// directions to both devices, the distance and the pattern position. Arguments as of ffp_light_backward, the
// camera that of the samples. Visibility, footprint and the distance of even light are constants.
void ffp_light_backward_aim(const FfpGbuffer *gbuffer, const FfpMapping *mapping, const FfpCamera *camera,
                            const FfpCamera *projector, const FfpTransport *grad, FfpAimGradient *out);

// ADDS what the rasterised splats give to the camera. Must follow ffp_rasterise_backward with the same
// arguments, whose `grad` was 0 before.
void ffp_rasterise_backward_aim(const FfpRaster *raster, const FfpGaussians *gaussians,
                                const FfpCamera *camera, const FfpRenderSettings *settings,
                                const FfpGbuffer *out, const FfpGbuffer *grad_out, const FfpGaussians *grad,
                                FfpAimGradient *aim);

#endif
