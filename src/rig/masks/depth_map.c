#include "rig/masks/depth_map.h"
#include <tgmath.h>
#include "core/base/alloc.h"

enum { SHOWN_LEAST = 4 }; // of the nine cells around one

FfpDepthMap ffp_depth_map_new(const FfpCamera *device, int width, int height) {
    FfpDepthMap map = {device, width, height, ffp_alloc((size_t)width * (size_t)height, sizeof(real))};
    ffp_depth_map_clear(&map);
    return map;
}

void ffp_depth_map_clear(FfpDepthMap *map) {
    for (int i = 0; i < map->width * map->height; i++) map->z[i] = INFINITY;
}

void ffp_depth_map_free(FfpDepthMap *map) {
    ffp_free(map->z);
    *map = (FfpDepthMap){0};
}

// A point's place in cells, and its depth.
static bool place(const FfpDepthMap *map, const real point[3], real *x, real *y, real *z) {
    *z = ffp_project(map->device, point, x, y);
    *x *= (real)map->width / (real)map->device->width;
    *y *= (real)map->height / (real)map->device->height;
    return *z > 0 && *x >= 0 && *y >= 0 && *x < (real)map->width && *y < (real)map->height;
}

bool ffp_depth_map_find(const FfpDepthMap *map, const real point[3], int *cell, real *z) {
    real x, y;
    if (!place(map, point, &x, &y, z)) return false;
    *cell = (int)y * map->width + (int)x;
    return true;
}

void ffp_depth_map_put(FfpDepthMap *map, const real point[3], real size) {
    real x, y, z;
    if (!place(map, point, &x, &y, &z)) return;
    const real half = 0.5F * size * map->device->fx * (real)map->width / ((real)map->device->width * z);
    const int left = (int)fmax((real)0, x - half), right = (int)fmin((real)(map->width - 1), x + half);
    const int top = (int)fmax((real)0, y - half), bottom = (int)fmin((real)(map->height - 1), y + half);
    for (int r = top; r <= bottom; r++)
        for (int c = left; c <= right; c++) map->z[r * map->width + c] = fmin(map->z[r * map->width + c], z);
}

real ffp_depth_map_around(const FfpDepthMap *map, int cell) {
    const int x = cell % map->width, y = cell / map->width;
    real least = INFINITY;
    int shown = 0;
    for (int k = 0; k < 9; k++) {
        const int c = x + k % 3 - 1, r = y + k / 3 - 1;
        if (c < 0 || r < 0 || c >= map->width || r >= map->height) continue;
        const real z = map->z[r * map->width + c];
        least = fmin(least, z), shown += isfinite(z);
    }
    return shown >= SHOWN_LEAST ? least : INFINITY;
}
