// Inside the render room: what rasterising and shading share on the CPU and on the GPU.
#ifndef FFP_RENDER_FORMULA_H
#define FFP_RENDER_FORMULA_H

#include "core/base/vec.h"
#include "core/capture/capture.h"

enum {
    FFP_TILE = 16,     // pixels a side
    FFP_CHANNELS = 15, // what is blended: 1, depth, normal 3, albedo 3, roughness, ambient 3, scattered 3
    FFP_DIRECT_CHANNELS = 12, // of Gaussians that scatter no light
    FFP_SHADOW_CHANNELS = 2,  // opacity and depth are enough for a shadow map
    FFP_CHANNEL_DEPTH = 1,
    FFP_CHANNEL_NORMAL = 2,
    FFP_CHANNEL_ALBEDO = 5,
    FFP_CHANNEL_ROUGHNESS = 8,
    FFP_CHANNEL_AMBIENT = 9,
    FFP_CHANNEL_SCATTERED = 12
};

#define FFP_ALPHA_MIN (1.0F / 255.0F)
#define FFP_ALPHA_MAX 0.99F
#define FFP_TRANSMITTANCE_MIN 1e-4F
// Below this opacity a pixel has no surface to shade: only its ambient counts.
#define FFP_OPACITY_MIN 1e-3F
// The least compensation: its square root has no slope at 0, where a flat splat is seen edge-on.
#define FFP_COMPENSATION_MIN 0.005F
// Of the image's side: farther outside x/z is held for the Jacobian's sake.
#define FFP_HOLD_MARGIN 0.15F

// World point at camera depth z on the ray of pixel position (x, y), and how it moves with z.
FFP_FORMULA void ffp_surface_point(const FfpCamera *camera, real x, real y, real z, real point[3],
                                   real slope[3]) {
    const real ray[3] = {(x - camera->cx) / camera->fx, (y - camera->cy) / camera->fy, 1};
    ffp_rotate(camera->pose, ray, slope);
    for (int i = 0; i < 3; i++) point[i] = camera->pose[4 * i + 3] + z * slope[i];
}

#endif
