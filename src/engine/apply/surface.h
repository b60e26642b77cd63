// The surface that a projector lights: the nearest one in every pixel of its pattern.
#ifndef FFP_APPLY_SURFACE_H
#define FFP_APPLY_SURFACE_H

#include "core/capture/capture.h"
#include "core/gaussians/gaussians.h"
#include "engine/render/render.h"

// Greater steps of depth than this between neighbouring pixels end a surface that is z away: four widths of a
// pixel.
static inline real ffp_depth_jump(const FfpCamera *device, real z) {
    return 4 * z / (device->fx < device->fy ? device->fx : device->fy);
}

// All images have the projector's size and one channel; 0 where there is no surface.
typedef struct FfpLitSurface {
    FfpGbuffer gbuffer;   // of the Gaussians, with the projector as the camera
    FfpImage depth;       // z from the projector, world units
    FfpImage cosine;      // of the angle of incidence
    FfpImage illuminance; // cosine / distance^2, 1 at its greatest
    FfpImage resolution;  // projector pixels per world unit of surface: root of pixels per unit area
} FfpLitSurface;

FfpLitSurface ffp_lit_surface_new(const FfpGaussians *gaussians, const FfpCamera *projector,
                                  const FfpRenderSettings *settings);
void ffp_lit_surface_free(FfpLitSurface *surface);

// Camera pixels in a projector pixel: the area of its image in the camera, through the surface's tangent
// plane; 0 where there is no surface or the camera lies behind it. Writes [projector's size, 1].
void ffp_lit_surface_density(const FfpLitSurface *surface, const FfpCamera *projector,
                             const FfpCamera *camera, FfpImage *density);

// The projector's share where several light the same place, not yet divided by the sum of all: it falls to
// (nearly) zero towards the edges of what it lights, depth jumps included, and with the angle of incidence.
// Writes [projector's size, 1], in (0,1].
void ffp_lit_surface_feather(const FfpLitSurface *surface, const FfpCamera *projector, FfpImage *feather);

// One channel of zeros and infinities: distances to the nearest zero, in pixels, by the two passes of a
// chamfer transform (Borgefors 1986).
void ffp_distances(FfpImage *distance);

#endif
