// Correspondence maps and what the projector lights.
#ifndef FFP_PIPELINE_CORRESPONDENCE_H
#define FFP_PIPELINE_CORRESPONDENCE_H

#include "core/capture/capture.h"
#include "core/gaussians/gaussians.h"
#include "core/image/named.h"
#include "ffprocams.h" // options and results, types alone (reconstruct.h says why)

// The work of ffp_warp_images (ffprocams/render.h), for a view's devices. `stats` may be NULL.
FfpImages *ffp_warps_of_view(const FfpGaussians *gaussians, const FfpCapture *capture, const FfpView *view,
                             FfpDrawing drawing, FfpWarpStats *stats, FfpError *err);
// True if a view's maps fit into memory, asked before the work; and the work, with any projector.
bool ffp_warps_fit(const FfpGaussians *gaussians, const FfpView *view, FfpDrawing drawing, FfpError *err);
FfpImages *ffp_warps_draw(const FfpGaussians *gaussians, const FfpCapture *capture, const FfpView *view,
                          FfpDrawing drawing, FfpWarpStats *stats);

#endif
