// Inside the render room: one view's projected splats, their order in every tile, and the steps between them.
#ifndef FFP_RENDER_RASTER_H
#define FFP_RENDER_RASTER_H

#include <stddef.h>
#include <stdint.h>
#include "base/vec.h"
#include "render/render.h"

enum {
    FFP_TILE = 16,           // pixels a side
    FFP_CHANNELS = 12,       // what is blended: 1, depth, normal 3, albedo 3, roughness, ambient 3
    FFP_SHADOW_CHANNELS = 2, // opacity and depth are enough for a shadow map
    FFP_CHANNEL_DEPTH = 1,
    FFP_CHANNEL_NORMAL = 2,
    FFP_CHANNEL_ALBEDO = 5,
    FFP_CHANNEL_ROUGHNESS = 8,
    FFP_CHANNEL_AMBIENT = 9
};

#define FFP_ALPHA_MIN (1.0F / 255.0F)
#define FFP_ALPHA_MAX 0.99F
#define FFP_TRANSMITTANCE_MIN 1e-4F
// Below this opacity a pixel has no surface to shade: only its ambient counts.
#define FFP_OPACITY_MIN 1e-3F

// A Gaussian as one view sees it.
typedef struct FfpSplat {
    real x, y;                                  // centre in pixels
    real conic[3];                              // A, B, C: sigma = (A dx^2 + C dy^2) / 2 + B dx dy
    real opacity;                               // compensated; 0: not drawn
    real value[FFP_CHANNELS];                   // blended attributes, in the order of the enum
    int32_t gaussian;                           // which Gaussian it is
    int32_t tile_x0, tile_y0, tile_x1, tile_y1; // tiles it may touch, end exclusive
    int32_t y0, y1;                             // image rows it may touch, end exclusive
} FfpSplat;

// Gradient of the loss with respect to one splat's fields (or one tile's part of it); channel 0 is constant.
typedef struct FfpSplatGrad {
    real x, y, conic[3], opacity, value[FFP_CHANNELS];
} FfpSplatGrad;

typedef struct FfpDepthKey {
    uint64_t key; // bits of the depth: for positive numbers they sort as the numbers do
    int32_t splat;
} FfpDepthKey;

struct FfpRaster {
    int width, height, tiles_x, tiles_y;
    int32_t n_splats;
    FfpSplat *splats; // Gaussians opaque enough to be seen, in the set's order (some still not drawn)
    FfpDepthKey *keys, *keys_swap;
    int64_t *first;      // [n_splats + 1] where a splat's tiles begin among the instances, splat-major
    int64_t *tile_first; // [tiles + 1] where a tile's splats begin in `order`
    int32_t *order;      // splats of every tile, near to far
    FfpSplatGrad *slots; // gradients of every (splat, tile) instance, splat-major
    size_t splats_size, keys_size, keys_swap_size, first_size, tile_first_size, order_size,
        slots_size;    // bytes
    FfpGbuffer shadow; // of these only opacity and depth
};

// Makes *block hold at least `count` elements of `size` bytes; its contents are lost when it has to grow.
void ffp_raster_reserve(void **block, size_t *held, size_t count, size_t size);

// project.c: fills raster->splats from the Gaussians of opacity >= 1/255. raster->width and ->height must be
// set.
void ffp_project_splats(FfpRaster *raster, const FfpGaussians *gaussians, const FfpCamera *camera,
                        const FfpRenderSettings *settings);
// Sums each splat's slots in order and adds what follows for the Gaussian's attributes to grad.
void ffp_project_splats_backward(const FfpRaster *raster, const FfpGaussians *gaussians,
                                 const FfpCamera *camera, const FfpRenderSettings *settings,
                                 FfpGaussians *grad);

// bin.c: fills first, tile_first and order.
void ffp_bin_splats(FfpRaster *raster);

// blend.c: the first `channels` channels into out (and the distortion when all are asked for).
void ffp_blend(const FfpRaster *raster, int channels, FfpGbuffer *out);
void ffp_blend_backward(FfpRaster *raster, const FfpGbuffer *out, const FfpGbuffer *grad_out); // fills slots

// World point at camera depth z on the ray of pixel position (x, y), and how it moves with z.
static inline void ffp_surface_point(const FfpCamera *camera, real x, real y, real z, real point[3],
                                     real slope[3]) {
    const real ray[3] = {(x - camera->cx) / camera->fx, (y - camera->cy) / camera->fy, 1};
    ffp_rotate(camera->pose, ray, slope);
    for (int i = 0; i < 3; i++) point[i] = camera->pose[4 * i + 3] + z * slope[i];
}

#endif
