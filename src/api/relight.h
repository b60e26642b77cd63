// A view under a pattern as a file holds it; its maps as pictures. Shared by rendering,
// evaluation and the report.
#ifndef FFP_API_RELIGHT_H
#define FFP_API_RELIGHT_H

#include <stdbool.h>
#include "ffprocams.h"
#include "capture/capture.h"
#include "network/network.h"
#include "render/pass.h"

// The view drawn last under a pattern: sRGB-encoded RGB rounded to 8 bits, so that metrics see what the file
// will hold.
FfpImage ffp_relight(FfpViewPass *pass, const real intensity[3], const FfpSummed *pattern);

void ffp_quantise(FfpImage *encoded); // clamps to [0,1] and rounds to multiples of 1/255, in place

// The settings that Gaussians are drawn with: the model's own form when there is one, and its samples unless
// the drawing names others.
FfpRenderSettings ffp_drawing_settings(FfpDrawing drawing, const FfpModel *model);

const char *ffp_map_name(FfpMap map);
// A viewable picture in [0,1]: depth near = bright over the view's own range, normals as (n + 1) / 2, colours
// encoded.
FfpImage ffp_map_picture(const FfpGbuffer *gbuffer, FfpMap map);
// Camera z in world units, one channel, 0 where the opacity is below one half.
FfpImage ffp_map_depth(const FfpGbuffer *gbuffer);

// An image file as a pattern of width x height: linear RGB over black, named after the file. Says so when it
// is resized.
bool ffp_pattern_read(FfpPattern *pattern, const char *path, int width, int height, FfpError *err);

// "folder/name" where name is "<view>_<rest>"; names come from files, so those that would leave the folder
// are refused.
bool ffp_picture_path(char *out, size_t size, const char *folder, const char *view, const char *rest,
                      FfpError *err);

#endif
