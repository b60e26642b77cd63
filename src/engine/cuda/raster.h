// One view's splats on the device: the same steps as engine/render/raster.h, one thread a Gaussian, a pair of
// splat and tile, or a pixel. Included behind launch.h.
#ifndef FFP_CUDA_RASTER_H
#define FFP_CUDA_RASTER_H

#include "engine/cuda/sort.h"
extern "C" {
#include "engine/render/formula.h"
#include "engine/render/table.h"
}

enum {
    FFP_SPLAT_QUADS = 5, // of four floats: a splat, and a pair's gradient
    FFP_TILE_PIXELS = FFP_TILE * FFP_TILE,
    FFP_TILE_WARPS = FFP_TILE_PIXELS / FFP_WARP,
    FFP_WARP_WIDTH = 8, // pixels of a tile that a warp draws
    FFP_WARP_HEIGHT = FFP_WARP / FFP_WARP_WIDTH
};

// A Gaussian as the view sees it.
typedef struct alignas(16) FfpDeviceSplat {
    float x, y;                    // centre in pixels
    float power[3];                // density = opacity 2^(p0 dx^2 + p1 dx dy + p2 dy^2)
    float opacity;                 // compensated
    float value[FFP_CHANNELS - 1]; // blended attributes behind the constant first
} FfpDeviceSplat;

// One tile's contribution to a splat's gradient, as FfpSplatGrad of engine/render/raster.h.
typedef struct alignas(16) FfpDeviceSplatGrad {
    float g, gx, gy, gxx, gxy, gyy;
    float value[FFP_CHANNELS - 1];
} FfpDeviceSplatGrad;

static_assert(sizeof(FfpDeviceSplat) == 16 * FFP_SPLAT_QUADS);
static_assert(sizeof(FfpDeviceSplatGrad) == 16 * FFP_SPLAT_QUADS);
enum { FFP_SPLAT_SUMS = 6 + FFP_CHANNELS - 1 }; // numbers in use of the latter

// The kernels' view of a raster. A pair is a splat and a tile that it may touch; pairs are counted splat by
// splat in the set's order, of each splat row by row of its tiles.
typedef struct FfpTiling {
    int width, height, tiles_x, tiles_y;
    float firmness; // of the settings
    int64_t gaussians, pairs;
    FfpDeviceSplat *splats; // [gaussians]
    int4 *boxes;      // [gaussians] pixels x0, y0, x1, y1 that it may touch, end exclusive; empty: not drawn
    int64_t *counts;  // [gaussians + 1] its pairs
    int64_t *first;   // [gaussians + 1] where they begin; the last: how many there are
    uint32_t *owners; // [pairs] the pair's Gaussian
    uint32_t *places; // [pairs] 0, 1, 2, ...
    uint32_t *order;  // [pairs] pairs tile by tile, in a tile near to far
    uint64_t *keys;   // [pairs] tile and bits of the depth: for positive numbers they sort as these do
    uint64_t *sorted_keys;     // [pairs]
    int64_t *tile_first;       // [tiles + 1] where a tile's pairs begin in `order`
    FfpDeviceSplatGrad *slots; // [pairs] gradients
    uint8_t *touched;          // [pairs] whether the pair's slot holds anything
} FfpTiling;

struct FfpDeviceRaster {
    FfpTiling tiling;
    size_t splats_size, boxes_size, counts_size, first_size, owners_size, places_size, order_size, keys_size,
        sorted_keys_size, tile_first_size, slots_size, touched_size; // bytes
    FfpSortScratch scratch;
};

// The tiles that a box touches, end exclusive.
static __device__ inline int4 ffp_box_tiles(int4 box) {
    return int4{box.x / FFP_TILE, box.y / FFP_TILE, (box.z + FFP_TILE - 1) / FFP_TILE,
                (box.w + FFP_TILE - 1) / FFP_TILE};
}

// Constants of a view.
typedef struct FfpDeviceView {
    FfpCamera camera;
    float blur, firmness;
    bool compensation;
} FfpDeviceView;

// project.cu: splats, boxes and counts of all Gaussians; and from the slots to the Gaussians' gradients,
// ADDED.
void ffp_cuda_project(const FfpTiling *tiling, const FfpGaussians *gaussians, const FfpDeviceView *view);
void ffp_cuda_project_backward(const FfpTiling *tiling, const FfpGaussians *gaussians,
                               const FfpDeviceView *view, FfpGaussians *grad);
// blend.cu: all planes that out has, or opacity and depth only. blend_backward.cu: the slots.
void ffp_cuda_blend(const FfpTiling *tiling, FfpGbuffer *out);
void ffp_cuda_blend_backward(const FfpTiling *tiling, const FfpGbuffer *out, const FfpGbuffer *grad_out);

#endif
