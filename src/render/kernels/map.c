// A row of pixels to the projector (map_pixel.h).
#include "render/kernels/kernels.h"

void FFP_K(map_row)(const FfpMapper *mapper, int y, FfpMapping *out) {
    for (int x = 0; x < mapper->gbuffer->width; x++) ffp_map_pixel(mapper, x, y, out);
}
