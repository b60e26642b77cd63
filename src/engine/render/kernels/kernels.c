// The table of one CPU level.
#include "engine/render/kernels/kernels.h"

const FfpRenderKernels FFP_K(render) = {
    .project_chunk = FFP_K(project_chunk),
    .project_chunk_backward = FFP_K(project_chunk_backward),
    .blend_tile = FFP_K(blend_tile),
    .blend_tile_backward = FFP_K(blend_tile_backward),
    .light_row = FFP_K(light_row),
    .light_row_backward = FFP_K(light_row_backward),
    .aim_row = FFP_K(aim_row),
    .focal_chunk = FFP_K(focal_chunk),
    .shade_row = FFP_K(shade_row),
    .shade_row_backward = FFP_K(shade_row_backward),
    .map_row = FFP_K(map_row),
    .average_row = FFP_K(average_row),
    .average_row_backward = FFP_K(average_row_backward),
    .resolve_row = FFP_K(resolve_row),
    .resolve_row_backward = FFP_K(resolve_row_backward),
};
