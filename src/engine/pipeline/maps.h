// A G-buffer's maps: as numbers, and as pictures to look at.
#ifndef FFP_PIPELINE_MAPS_H
#define FFP_PIPELINE_MAPS_H

#include "engine/render/render.h"
#include "ffprocams.h"

enum { FFP_MAP_PICTURES = FFP_MAP_DISTORTION }; // those before it are looked at
const char *ffp_map_name(FfpMap map);
// A viewable picture in [0,1]: depth near = bright over the view's own range, normals as (n + 1) / 2, colours
// encoded.
FfpImage ffp_map_picture(const FfpGbuffer *gbuffer, FfpMap map);
// Camera z in world units, one channel, 0 where the opacity is below one half.
FfpImage ffp_map_depth(const FfpGbuffer *gbuffer);
// The values of ffp_renderer_map (ffprocams/render.h): means over each pixel, distortion sums.
int ffp_map_width(FfpMap map); // numbers of a pixel
void ffp_map_values(const FfpGbuffer *gbuffer, FfpMap map, float *out);
// ADDS to the G-buffer's gradient, from that of the values. Which pixels have a surface is a constant.
void ffp_map_values_backward(const FfpGbuffer *gbuffer, FfpMap map, const float *grad, FfpGbuffer *to);

#endif
