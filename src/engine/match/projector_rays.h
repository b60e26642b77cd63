// Free space from a projector's light: its rays are empty up to the surface that they light.
#ifndef FFP_MATCH_PROJECTOR_RAYS_H
#define FFP_MATCH_PROJECTOR_RAYS_H

#include <stdbool.h>
#include "engine/match/consistency.h"

// The trusted points of a view on a grid of its projector's picture; a cell is about as wide as a camera
// pixel.
typedef struct FfpProjectorRays {
    int width, height;
    real scale; // cells per pattern pixel
    FfpDepthBounds
        *bounds; // [height,width], of the four cells whose upper left one it is; depths from the projector
} FfpProjectorRays;

FfpProjectorRays ffp_projector_rays_new(const FfpDepths *depths, int view);
void ffp_projector_rays_free(FfpProjectorRays *projector_rays);

// The cell that holds position (u, v) of the grid; false outside it.
static inline bool ffp_projector_rays_cell(const FfpProjectorRays *projector_rays, real u, real v,
                                           size_t *cell) {
    if (!(u >= 0 && v >= 0 && u < (real)projector_rays->width && v < (real)projector_rays->height))
        return false;
    *cell = (size_t)v * (size_t)projector_rays->width + (size_t)u;
    return true;
}

// The depths around the pattern's position (u, v); all 0 outside the grid.
static inline FfpDepthBounds ffp_projector_rays_at(const FfpProjectorRays *projector_rays, real u, real v) {
    const real scale = projector_rays->scale;
    size_t cell;
    if (!ffp_projector_rays_cell(projector_rays, u * scale - 0.5F, v * scale - 0.5F, &cell))
        return (FfpDepthBounds){0, 0, 0};
    return projector_rays->bounds[cell];
}

#endif
