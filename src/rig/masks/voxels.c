#include "rig/masks/voxels.h"
#include <tgmath.h>
#include "core/base/alloc.h"

static int count(const FfpVoxels *voxels) {
    return voxels->side * voxels->side * voxels->side;
}

FfpVoxels ffp_voxels_new(const FfpCapture *capture, int side) {
    FfpVoxels out = {.side = side, .step = 2 * capture->radius / (real)side};
    for (int k = 0; k < 3; k++) out.low[k] = capture->centre[k] - capture->radius;
    out.solid = ffp_alloc((size_t)count(&out), 1);
    return out;
}

void ffp_voxels_free(FfpVoxels *voxels) {
    ffp_free(voxels->solid);
    *voxels = (FfpVoxels){0};
}

void ffp_voxels_point(const FfpVoxels *voxels, int index, real point[3]) {
    const int side = voxels->side, at[3] = {index % side, index / side % side, index / (side * side)};
    for (int k = 0; k < 3; k++) point[k] = voxels->low[k] + ((real)at[k] + 0.5F) * voxels->step;
}

int ffp_voxels_find(const FfpVoxels *voxels, const real point[3]) {
    const int side = voxels->side;
    int at[3];
    for (int k = 0; k < 3; k++) {
        const real place = (point[k] - voxels->low[k]) / voxels->step;
        at[k] = (int)fmin(fmax(place, (real)0), (real)(side - 1));
    }
    return (at[2] * side + at[1]) * side + at[0];
}

void ffp_voxels_draw(const FfpVoxels *voxels, FfpDepthMap *map) {
    ffp_depth_map_clear(map);
    for (int i = 0; i < count(voxels); i++) {
        real point[3];
        if (!voxels->solid[i]) continue;
        ffp_voxels_point(voxels, i, point);
        ffp_depth_map_put(map, point, voxels->step);
    }
}
