// A projector's warp for media servers and 3D programs.
#ifndef FFP_PIPELINE_WARP_FILES_H
#define FFP_PIPELINE_WARP_FILES_H

#include "core/capture/capture.h"

// `map`: ffp_view_maps' projector_to_camera [h,w,3]: the camera's pixel that sees each projector pixel, -1 -1
// 0 where none does; `camera` gives its size. u, v: shares of the camera's picture, u to the right and v up
// from its lower left corner, as STMaps and texture coordinates have them.
//
// An STMap: float EXR of the projector's size, R: u, G: v, B: 0, A: 1; all 0 where there is nothing.
bool ffp_write_stmap(const FfpImage *map, const FfpCamera *camera, const char *path, FfpError *err);
// A mesh (OBJ) in the projector's frame: triangles between pixel centres, x to the right and y up in shares
// of its picture, z 0, with u, v as texture coordinates; at most 128 cells along the longer side. Cells with
// a corner that sees nothing, or across a step in depth, are left out.
bool ffp_write_warp(const FfpImage *map, const FfpCamera *camera, const char *path, FfpError *err);

#endif
