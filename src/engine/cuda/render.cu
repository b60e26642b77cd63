// The render room's table.
#include "engine/cuda/cuda.h"
#include "engine/cuda/launch.h"
#include "engine/cuda/render.h"

const FfpRenderTable ffp_cuda_render = {
    .raster_new = ffp_cuda_raster_new,
    .raster_free = ffp_cuda_raster_free,
    .rasterise = ffp_cuda_rasterise,
    .rasterise_backward = ffp_cuda_rasterise_backward,
    .map_with_shadow = ffp_cuda_map_with_shadow,
    .light = ffp_cuda_light,
    .light_backward = ffp_cuda_light_backward,
    .shade = ffp_cuda_shade,
    .shade_backward = ffp_cuda_shade_backward,
    .gbuffer_clear = ffp_cuda_gbuffer_clear,
    .average_plane = ffp_cuda_average_plane,
    .average_gbuffer = ffp_cuda_average_gbuffer,
    .average_gbuffer_backward = ffp_cuda_average_gbuffer_backward,
    .resolve = ffp_cuda_resolve,
    .resolve_backward = ffp_cuda_resolve_backward,
};
