// Blending of all tiles, and its gradient.
#include <string.h>
#include "engine/render/kernels/kernels.h"

void ffp_blend(const FfpRaster *raster, int channels, FfpGbuffer *out) {
    const int tiles = raster->tiles_x * raster->tiles_y;
    FfpBlendTile *blend = ffp_render_kernels()->blend_tile;
#pragma omp parallel for schedule(dynamic)
    for (int t = 0; t < tiles; t++) blend(raster, t, channels, out);
}

void ffp_blend_backward(FfpRaster *raster, const FfpGbuffer *out, const FfpGbuffer *grad_out) {
    const int tiles = raster->tiles_x * raster->tiles_y;
    const size_t instances = (size_t)raster->instances;
    ffp_raster_reserve((void **)&raster->slots, &raster->slots_size, instances + 1, sizeof(FfpSplatGrad));
    ffp_raster_reserve((void **)&raster->touched, &raster->touched_size, instances + 1, sizeof(uint8_t));
    memset(raster->touched, 0, instances);
    FfpBlendTileBackward *backward = ffp_render_kernels()->blend_tile_backward;
#pragma omp parallel for schedule(dynamic)
    for (int t = 0; t < tiles; t++) backward(raster, t, out, grad_out);
}
