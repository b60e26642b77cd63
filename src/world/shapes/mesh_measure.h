// Measures of a mesh that do not depend on how it is turned.
#ifndef FFP_SHAPES_MESH_MEASURE_H
#define FFP_SHAPES_MESH_MEASURE_H

#include "world/shapes/mesh.h"

// Handles of a closed surface, all its components together, from the Euler characteristic: V - E + F =
// 2 (components - genus) with E = 3/2 F. Also gives the number of components.
int ffp_mesh_genus(const FfpMesh *mesh, int *components);

#endif
