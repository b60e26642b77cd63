// Inside the export room: the signed distance that views' depth maps agree on, and what they see of a
// surface.
#ifndef FFP_EXPORT_VOLUME_H
#define FFP_EXPORT_VOLUME_H

#include "product/export/mesh.h"

typedef struct FfpVolume {
    int size[3]; // points along x, y, z
    real low[3]; // the first point
    real cell;   // from one point to the next, world units
    real truncation;
    real *distance; // [z,y,x] in truncations, -1 to 1, above 0 outside
} FfpVolume;

// A camera's view of the Gaussians, with pixels about as fine as the cells.
typedef struct FfpDepthView {
    FfpCamera camera;
    FfpGbuffer gbuffer;
} FfpDepthView;
typedef struct FfpDepthSource {
    const FfpGaussians *gaussians;
    const FfpCapture *capture;
    const FfpRenderSettings *settings;
    FfpRaster *raster;
} FfpDepthSource;
FfpDepthView ffp_depth_view(const FfpDepthSource *source, int view, real cell);
void ffp_depth_view_free(FfpDepthView *seen);
// The pixel that a world point falls on, with its depth from the camera; -1: outside the picture.
int ffp_depth_view_pixel(const FfpDepthView *seen, const real point[3], real *depth);
// Cosine between the pixel's normal and the way to the camera, 0 where there is no surface.
real ffp_depth_view_facing(const FfpDepthView *seen, int pixel, const real point[3]);

FfpVolume ffp_volume_fuse(const FfpDepthSource *source, int resolution);
void ffp_volume_free(FfpVolume *volume);

// Vertices and quads of the zero; nothing else of the mesh.
void ffp_surface_nets(FfpVolume *volume, FfpSurface *mesh);
// Leaves out pieces of fewer quads than a twentieth of the largest piece's.
void ffp_surface_drop_loose(FfpSurface *mesh);
// Fills in the textures.
void ffp_surface_paint(FfpSurface *mesh, const FfpDepthSource *source, const FfpVolume *volume);

#endif
