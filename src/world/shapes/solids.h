// Simple solids as meshes: closed, wound outwards, without texture coordinates.
#ifndef FFP_SHAPES_SOLIDS_H
#define FFP_SHAPES_SOLIDS_H

#include "world/shapes/mesh.h"

// A box of the given half sides about `centre`, turned about its vertical axis by an angle in radians.
FfpMesh ffp_solid_box(const float centre[3], const float half[3], float angle);
// An upright cylinder about the z axis between two heights.
FfpMesh ffp_solid_cylinder(float radius, float bottom, float top);

#endif
