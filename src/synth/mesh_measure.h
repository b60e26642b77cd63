// What a mesh is like, in figures that do not depend on how it is turned.
#ifndef FFP_SYNTH_MESH_MEASURE_H
#define FFP_SYNTH_MESH_MEASURE_H

#include "synth/mesh.h"

enum {
    FFP_SIGNATURE_DISTANCES = 24,
    FFP_SIGNATURE_ANGLES = 8,
    FFP_SIGNATURE = FFP_SIGNATURE_DISTANCES * FFP_SIGNATURE_ANGLES
};

// Handles of a closed surface, all its components together, from the Euler characteristic: V - E + F =
// 2 (components - genus) with E = 3/2 F. Also gives the number of components.
int ffp_mesh_genus(const FfpMesh *mesh, int *components);
// Distribution over pairs of surface points of their distance and of the cosine between their normals:
// the shape distribution D2 (Osada et al. 2002) with one angle of the surflet pairs (Wahl et al. 2003).
// histogram[FFP_SIGNATURE] sums to 1. The mesh is placed, that is, within FFP_MESH_RADIUS.
void ffp_mesh_signature(const FfpMesh *mesh, float *histogram);
// Half the sum of the absolute differences of two signatures: 0 for the same, 1 for nothing in common.
float ffp_signature_distance(const float *a, const float *b);

#endif
