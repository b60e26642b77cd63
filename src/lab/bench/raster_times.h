// Times the rasteriser and the shading on splats laid as the network lays them.
#ifndef FFP_BENCH_RASTER_TIMES_H
#define FFP_BENCH_RASTER_TIMES_H

#include "core/gaussians/gaussians.h"
#include "engine/render/render.h"

// Milliseconds of one view, the least of the repeats; the parts of rasterise and of its backward pass beside
// them.
typedef struct FfpRasterTimes {
    double project, bin, blend, rasterise; // rasterise: all three, as called by users
    double shade, map;                     // map: with its shadow map
    double blend_backward, project_backward, rasterise_backward, shade_backward;
    int64_t splats, instances; // Gaussians of opacity 1/255 and more; (splat, tile) pairs
} FfpRasterTimes;

// 8 side^2 splats of the given opacity: a ball on a ground as eight cameras around it see it, one splat a
// pixel, flat along the normal, half a pixel's footprint times `size` wide. Freed by the caller.
FfpGaussians ffp_bench_splats(int side, real opacity, real size);
// A camera of side x side pixels between two of those eight.
FfpCamera ffp_bench_camera(int side);
// Forward and backward of the camera's view under a white pattern from a projector above it. The gradients
// are random.
FfpRasterTimes ffp_time_raster(const FfpGaussians *gaussians, const FfpCamera *camera, int repeats);

#endif
