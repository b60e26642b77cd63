// The parts of drawing that exist once for each CPU level (core/base/cpu.h). Every source in this folder is
// compiled once a level, with FFP_LEVEL set to the level's name and that level's instructions.
#ifndef FFP_RENDER_KERNELS_KERNELS_H
#define FFP_RENDER_KERNELS_KERNELS_H

#include "core/base/level.h"
#include "engine/render/aim.h"
#include "engine/render/map_pixel.h"
#include "engine/render/raster.h"
#include "engine/render/shade_pixel.h"

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

// Operands of ffp_shade_backward, read and added to.
typedef struct FfpShadeGrad {
    const FfpImage *image;
    real *ambient, *scattered; // the latter or NULL
    FfpTransport *transport;
    FfpSummed *pattern; // or NULL
} FfpShadeGrad;

// The surface that the projector's light falls on.
typedef struct FfpLitScene {
    const FfpGbuffer *gbuffer;
    const FfpMapping *mapping;
    FfpLitView view;
} FfpLitScene;

// Of a row's samples: adds to out what the row's light gives to the devices' gradients; of a chunk's splats:
// what their projection gives to the focal lengths, [2].
typedef void FfpAimRow(const FfpLitScene *scene, int y, const FfpTransport *grad, FfpAimGradient *out);
typedef void FfpFocalChunk(const FfpRaster *raster, const FfpGaussians *gaussians, const FfpCamera *camera,
                           const FfpRenderSettings *settings, const FfpChunk *chunk, double focal[2]);

// Row y of the transport, of the picture, of their gradients (grad_intensity is the row's own), of the
// mapping.
typedef void FfpLightRow(const FfpLitScene *scene, int y, FfpTransport *out);
typedef void FfpLightRowBackward(const FfpLitScene *scene, int y, const FfpTransport *grad,
                                 FfpGbuffer *grad_gbuffer);
typedef void FfpShadeRow(const FfpPatternLight *light, int y, const FfpGbuffer *gbuffer, FfpImage *out);
typedef void FfpShadeRowBackward(const FfpPatternLight *light, int y, const FfpShadeGrad *grad,
                                 real grad_intensity[3]);
typedef void FfpMapRow(const FfpMapper *mapper, int y, FfpMapping *out);

// A row of [width,channels] means of side x side samples, from the first of its rows of samples; or that
// row's gradient, set in its samples.
typedef void FfpAverageRow(const real *from, int width, int channels, int side, real *to);

// A row of `count` pixels: ffp_resolve and ffp_resolve_backward.
typedef void FfpResolveRow(const real *mean, const real *opacity, int count, int side, real *picture);
typedef void FfpResolveRowBackward(const real *mean, const real *opacity, int count, int side,
                                   const real *grad_picture, real *grad_mean, real *grad_opacity);

typedef struct FfpRenderKernels {
    FfpProjectChunk *project_chunk;
    FfpProjectChunkBackward *project_chunk_backward;
    FfpBlendTile *blend_tile;
    FfpBlendTileBackward *blend_tile_backward;
    FfpLightRow *light_row;
    FfpLightRowBackward *light_row_backward;
    FfpAimRow *aim_row;
    FfpFocalChunk *focal_chunk;
    FfpShadeRow *shade_row;
    FfpShadeRowBackward *shade_row_backward;
    FfpMapRow *map_row;
    FfpAverageRow *average_row, *average_row_backward;
    FfpResolveRow *resolve_row;
    FfpResolveRowBackward *resolve_row_backward;
} FfpRenderKernels;

FFP_LOOP_TABLES(FfpRenderKernels, render)

#ifdef FFP_LEVEL
FfpProjectChunk FFP_K(project_chunk);
FfpProjectChunkBackward FFP_K(project_chunk_backward);
FfpBlendTile FFP_K(blend_tile);
FfpBlendTileBackward FFP_K(blend_tile_backward);
FfpLightRow FFP_K(light_row);
FfpLightRowBackward FFP_K(light_row_backward);
FfpAimRow FFP_K(aim_row);
FfpFocalChunk FFP_K(focal_chunk);
FfpShadeRow FFP_K(shade_row);
FfpShadeRowBackward FFP_K(shade_row_backward);
FfpMapRow FFP_K(map_row);
FfpAverageRow FFP_K(average_row), FFP_K(average_row_backward);
FfpResolveRow FFP_K(resolve_row);
FfpResolveRowBackward FFP_K(resolve_row_backward);
#endif

#endif
