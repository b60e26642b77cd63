// The parts of the rasteriser that exist once for each CPU level (base/cpu.h). Every source in this folder is
// compiled once a level, with FFP_LEVEL set to the level's name and that level's instructions.
#ifndef FFP_RENDER_KERNELS_KERNELS_H
#define FFP_RENDER_KERNELS_KERNELS_H

#include "base/level.h"
#include "render/raster.h"

// A chunk's splats; sets its `drawn`.
typedef void FfpProjectChunk(FfpRaster *raster, const FfpGaussians *gaussians, const FfpCamera *camera,
                             const FfpRenderSettings *settings, FfpChunk *chunk);
// From the slots of a chunk's splats: adds to grad.
typedef void FfpProjectChunkBackward(const FfpRaster *raster, const FfpGaussians *gaussians,
                                     const FfpCamera *camera, const FfpRenderSettings *settings,
                                     const FfpChunk *chunk, FfpGaussians *grad);
// A tile's pixels of out.
typedef void FfpBlendTile(const FfpRaster *raster, int tile, int channels, FfpGbuffer *out);
// A tile's slots, and which of them hold anything.
typedef void FfpBlendTileBackward(FfpRaster *raster, int tile, const FfpGbuffer *out,
                                  const FfpGbuffer *grad_out);

typedef struct FfpRenderKernels {
    FfpProjectChunk *project_chunk;
    FfpProjectChunkBackward *project_chunk_backward;
    FfpBlendTile *blend_tile;
    FfpBlendTileBackward *blend_tile_backward;
} FfpRenderKernels;

extern const FfpRenderKernels ffp_portable_render, ffp_avx2_render, ffp_avx512_render, ffp_avx512bf16_render,
    ffp_amx_render;

// The table of the CPU level in use (dispatch.c).
const FfpRenderKernels *ffp_render_kernels(void);

#ifdef FFP_LEVEL
FfpProjectChunk FFP_K(project_chunk);
FfpProjectChunkBackward FFP_K(project_chunk_backward);
FfpBlendTile FFP_K(blend_tile);
FfpBlendTileBackward FFP_K(blend_tile_backward);
#endif

#endif
