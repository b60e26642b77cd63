// Poses corrected from a capture's photographs.
#ifndef FFP_PIPELINE_ALIGN_H
#define FFP_PIPELINE_ALIGN_H

#include "core/capture/capture.h"
#include "ffprocams.h" // options and results, types alone (reconstruct.h says why)

// The work of ffp_align_poses (ffprocams/rig.h), in place. `stats` may be NULL.
bool ffp_alignment_run(FfpCapture *capture, const FfpAlignment *options, FfpAlignmentStats *stats,
                       FfpError *err);

#endif
