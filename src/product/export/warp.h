// A projector's warp for media servers and 3D programs.
#ifndef FFP_EXPORT_WARP_H
#define FFP_EXPORT_WARP_H

#include <stdint.h>
#include "core/capture/capture.h"

// `map`: ffp_view_maps' projector_to_camera [h,w,3]: the camera's pixel that sees each projector pixel, -1 -1
// 0 where none does; `camera` gives its size. u, v: shares of the camera's picture, u to the right and v up
// from its lower left corner, as STMaps and texture coordinates have them.
//
// An STMap: float EXR of the projector's size, R: u, G: v, B: 0, A: 1; all 0 where there is nothing.
bool ffp_write_stmap(const FfpImage *map, const FfpCamera *camera, const char *path, FfpError *err);

// The same as a mesh in the projector's frame: triangles between pixel centres, x to the right and y up in
// shares of its picture, z 0, with u, v as texture coordinates; at most 128 cells along the longer side,
// halved down to single pixels where a corner sees nothing, or the camera sees a step in depth, which is left
// out.
typedef struct FfpWarp {
    real *position, *texture; // [n_corners,3], [n_corners,2]
    uint32_t *corners;        // [n_triangles,3] counter-clockwise, y up
    uint32_t n_corners;
    size_t n_triangles;
} FfpWarp;

FfpWarp ffp_warp_of_map(const FfpImage *map, const FfpCamera *camera);
void ffp_warp_free(FfpWarp *warp);
bool ffp_warp_write_obj(const FfpWarp *warp, const char *path, FfpError *err);
// GLB, where v counts from above, with an unlit material for the content.
bool ffp_warp_write_gltf(const FfpWarp *warp, const char *path, FfpError *err);

#endif
