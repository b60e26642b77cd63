// Correspondence maps, what the projector lights, and the projector's warp, in files.
#ifndef FFP_EXPORT_MAP_FILES_H
#define FFP_EXPORT_MAP_FILES_H

#include "core/capture/capture.h"
#include "core/gaussians/gaussians.h"
#include "ffprocams.h"

// The work of ffp_write_warps (ffprocams/render.h): the number of files, or -1.
int ffp_warps_run(const FfpGaussians *gaussians, const FfpCapture *capture, const FfpWarps *options,
                  FfpWarpStats *stats, int n_stats, FfpError *err);

#endif
