// The parts of drawing that exist once for each CPU level (base/cpu.h). Every source in this folder is
// compiled once a level, with FFP_LEVEL set to the level's name and that level's instructions.
#ifndef FFP_RENDER_KERNELS_KERNELS_H
#define FFP_RENDER_KERNELS_KERNELS_H

#include "base/level.h"
#include "render/map_pixel.h"
#include "render/raster.h"
#include "render/shade_pixel.h"

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

// Row y of the picture, of its gradient (ffp_shade_backward: grad_intensity is the row's own), of the
// mapping.
typedef void FfpShadeRow(const FfpShader *shader, int y, FfpImage *out);
typedef void FfpShadeRowBackward(const FfpShader *shader, int y, const FfpImage *grad_image,
                                 FfpGbuffer *grad_gbuffer, real grad_intensity[3], FfpSummed *grad_pattern);
typedef void FfpMapRow(const FfpMapper *mapper, int y, FfpMapping *out);

typedef struct FfpRenderKernels {
    FfpProjectChunk *project_chunk;
    FfpProjectChunkBackward *project_chunk_backward;
    FfpBlendTile *blend_tile;
    FfpBlendTileBackward *blend_tile_backward;
    FfpShadeRow *shade_row;
    FfpShadeRowBackward *shade_row_backward;
    FfpMapRow *map_row;
} FfpRenderKernels;

FFP_LOOP_TABLES(FfpRenderKernels, render)

#ifdef FFP_LEVEL
FfpProjectChunk FFP_K(project_chunk);
FfpProjectChunkBackward FFP_K(project_chunk_backward);
FfpBlendTile FFP_K(blend_tile);
FfpBlendTileBackward FFP_K(blend_tile_backward);
FfpShadeRow FFP_K(shade_row);
FfpShadeRowBackward FFP_K(shade_row_backward);
FfpMapRow FFP_K(map_row);
#endif

#endif
