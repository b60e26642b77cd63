// Pictures of Gaussians in files: views under patterns, orbits, films, and the G-buffers.
#ifndef FFP_PIPELINE_PICTURES_H
#define FFP_PIPELINE_PICTURES_H

#include "core/capture/capture.h"
#include "core/gaussians/gaussians.h"
#include "ffprocams.h" // options, types alone (reconstruct.h says why)

// The work of ffp_render_pictures (ffprocams/render.h): the number of pictures written, or -1.
int ffp_pictures_run(const FfpGaussians *gaussians, const FfpCapture *capture, const FfpPictures *options,
                     FfpError *err);

#endif
