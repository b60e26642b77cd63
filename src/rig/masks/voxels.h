// A cube of voxels around a capture's sphere.
#ifndef FFP_RIG_VOXELS_H
#define FFP_RIG_VOXELS_H

#include "rig/masks/depth_map.h"

typedef struct FfpVoxels {
    int side;             // voxels along each edge
    real low[3], step;    // the cube's lowest corner and a voxel's edge, world units
    unsigned char *solid; // [side*side*side], x first, owned
} FfpVoxels;

FfpVoxels ffp_voxels_new(const FfpCapture *capture, int side); // none is solid
void ffp_voxels_free(FfpVoxels *voxels);

void ffp_voxels_point(const FfpVoxels *voxels, int index, real point[3]); // a voxel's middle
// The voxel of a point; that at the edge for a point outside the cube.
int ffp_voxels_find(const FfpVoxels *voxels, const real point[3]);
// Clears the map and draws all that is solid into it.
void ffp_voxels_draw(const FfpVoxels *voxels, FfpDepthMap *map);

#endif
