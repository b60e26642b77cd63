// The nearest surface that a camera or projector sees, on a coarse grid over its picture.
#ifndef FFP_RIG_DEPTH_MAP_H
#define FFP_RIG_DEPTH_MAP_H

#include "core/capture/capture.h"

typedef struct FfpDepthMap {
    const FfpCamera *device; // not owned
    int width, height;       // cells
    real *z; // [height*width] least depth along the device's axis, world units; INFINITY: nothing
} FfpDepthMap;

FfpDepthMap ffp_depth_map_new(const FfpCamera *device, int width, int height);
void ffp_depth_map_clear(FfpDepthMap *map);
void ffp_depth_map_free(FfpDepthMap *map);

// Where a point of the world lies: its cell, counted row by row, and its depth; false outside the picture.
bool ffp_depth_map_find(const FfpDepthMap *map, const real point[3], int *cell, real *z);
// Puts a square of `size` world units (0: its cell alone), facing the device, around a point.
void ffp_depth_map_put(FfpDepthMap *map, const real point[3], real size);
// The least depth in the 3 x 3 cells around a cell; INFINITY where fewer than four of them show anything.
real ffp_depth_map_around(const FfpDepthMap *map, int cell);

#endif
