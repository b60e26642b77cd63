// What a projector's light says about space: up to where it first meets a surface, it is empty.
#ifndef FFP_MATCH_PROJECTOR_RAYS_H
#define FFP_MATCH_PROJECTOR_RAYS_H

#include "match/consistency.h"

// The trusted points of a view on a grid of its projector's picture; a cell is about as wide as a camera
// pixel.
typedef struct FfpProjectorRays {
    int width, height;
    real scale; // cells a pattern pixel
    FfpDepthBounds
        *bounds; // [height,width], of the four cells whose upper left one it is; depths from the projector
} FfpProjectorRays;

FfpProjectorRays ffp_projector_rays_new(const FfpDepths *depths, int view);
void ffp_projector_rays_free(FfpProjectorRays *projector_rays);

// What is known around the pattern's position (u, v); all 0 outside the grid.
FfpDepthBounds ffp_projector_rays_at(const FfpProjectorRays *projector_rays, real u, real v);

#endif
