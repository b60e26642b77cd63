// A closed surface of the Gaussians with albedo and roughness in textures.
#ifndef FFP_EXPORT_MESH_H
#define FFP_EXPORT_MESH_H

#include <stdint.h>
#include "core/capture/capture.h"
#include "core/gaussians/gaussians.h"
#include "engine/render/render.h"

enum { FFP_TILE_TEXELS = 4 }; // a side of a quad's own part of the textures

typedef struct FfpSurface {
    uint32_t n_vertices, n_quads;
    real *position;   // [n_vertices,3] world
    real *normal;     // [n_vertices,3] unit, outwards
    uint32_t *quads;  // [n_quads,4] vertices, counter-clockwise seen from outside
    int tiles_across; // quad q has the tile in column q % tiles_across, row q / tiles_across of the textures;
                      // its corners lie at the centres of the tile's corner texels, in the order 00, 10, 11,
                      // 01
    FfpImage albedo;  // 3 channels, linear
    FfpImage roughness; // 1 channel
} FfpSurface;

// Depth maps of the Gaussians from the capture's cameras, fused into a truncated signed distance (Curless and
// Levoy 1996) on a grid of `resolution` cells along the longest side; its zero as quads, one vertex a cell
// (surface nets: Gibson 1998); small loose pieces dropped; attributes from the same views, weighted by how
// much they face the surface. Space that no camera sees into counts as inside where three quarters of their
// pictures hold it, so the surface is closed.
// Errors (where: `where`): no surface is found.
bool ffp_surface_of_gaussians(FfpSurface *mesh, const FfpGaussians *gaussians, const FfpCapture *capture,
                              const FfpRenderSettings *settings, int resolution, const char *where,
                              FfpError *err);
void ffp_surface_rotate(FfpSurface *mesh, const real turn[4]); // positions and normals, by a quaternion
void ffp_surface_free(FfpSurface *mesh);

bool ffp_surface_write_gltf(const FfpSurface *mesh, const char *path, bool binary, FfpError *err);
// Triangles with coloured vertices ("v x y z r g b", sRGB), which Blender and MeshLab read.
bool ffp_surface_write_obj(const FfpSurface *mesh, const char *path, FfpError *err);

#endif
