// Correspondence maps and what the projector lights: of one view in memory, of many in files.
#ifndef FFP_PIPELINE_MAP_FILES_H
#define FFP_PIPELINE_MAP_FILES_H

#include "core/capture/capture.h"
#include "core/gaussians/gaussians.h"
#include "core/image/named.h"
#include "ffprocams.h" // options and results, types alone (reconstruct.h says why)

// The work of ffp_map_images (ffprocams.h), for a view's devices. `stats` may be NULL.
FfpImages *ffp_maps_of_view(const FfpGaussians *gaussians, const FfpCapture *capture, const FfpView *view,
                            FfpDrawing drawing, FfpMapStats *stats, FfpError *err);
// The work of ffp_write_maps: the number of files, or -1.
int ffp_maps_run(const FfpGaussians *gaussians, const FfpCapture *capture, const FfpMaps *options,
                 FfpMapStats *stats, FfpError *err);

#endif
