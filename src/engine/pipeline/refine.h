// Gaussians fitted to a capture's photographs, in the capture's own units.
#ifndef FFP_PIPELINE_REFINE_H
#define FFP_PIPELINE_REFINE_H

#include "core/capture/capture.h"
#include "core/gaussians/gaussians.h"
#include "ffprocams.h" // options and results, types alone (reconstruct.h says why)

// The work of ffp_refine_gaussians (ffprocams/reconstruct.h), on a copy: a failure leaves the Gaussians
// unchanged, to the bit. `stats` may be NULL.
bool ffp_refinement_run(FfpGaussians *gaussians, const FfpCapture *capture, const FfpRefinement *options,
                        FfpRefinementStats *stats, FfpError *err);

#endif
