// Triangle meshes: made from a shape by surface nets, watertight, wound outwards, in the unit ball.
#ifndef FFP_SHAPES_MESH_H
#define FFP_SHAPES_MESH_H

#include <stdbool.h>
#include <stdint.h>
#include "core/base/error.h"
#include "world/shapes/shape.h"

#define FFP_MESH_RADIUS 0.95F // bounding sphere of every mesh, centred at the origin

typedef struct FfpMesh {
    int n_vertices, n_triangles;
    float *positions;    // [n_vertices, 3] and one float of padding, which Embree asks for
    float *normals;      // [n_vertices, 3] unit, outward, smooth
    uint32_t *triangles; // [n_triangles, 3] counter-clockwise seen from outside
    float *uv;           // [n_vertices, 2] texture coordinates, v up; NULL: none (all generated meshes)
    bool two_sided;      // nothing is known about winding and closedness: both sides are the surface
} FfpMesh;

// Surface nets (Gibson 1998) on a grid over the shape's bounds; every edge has exactly two triangles. 3,000
// to 60,000 triangles: the grid is chosen so. Closed-in bubbles and crumbs are left out. Not yet placed.
FfpMesh ffp_mesh_from_shape(const FfpShape *shape);
// Rotates by a row-major 3x3 matrix, then moves and scales into the bounding sphere of FFP_MESH_RADIUS at the
// origin.
void ffp_mesh_place(FfpMesh *mesh, const float rotation[9]);
int ffp_mesh_count(void);
const char *ffp_mesh_name(int mesh);
// The meshes of a split ("train", "validation", "test"), disjoint and together all. Returns the count, ids
// into out.
int ffp_split_meshes(const char *split, int *out, int capacity);
// Mesh number `mesh` of ffp_mesh_count(): a pure function of the number.
FfpMesh ffp_mesh_make(int mesh);
// A user's OBJ, PLY, STL or glTF file, turned z up (OBJ and glTF are taken for y up), placed as above. Smooth
// normals where the file has none but facets'. Errors: not such a file, no triangle, vertices that are not
// finite or all in one place, more than 20 million triangles.
bool ffp_mesh_read(FfpMesh *mesh, const char *path, FfpError *err);
void ffp_mesh_free(FfpMesh *mesh);

#endif
