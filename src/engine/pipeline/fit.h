// Code shared by all fits to a capture's pictures.
#ifndef FFP_PIPELINE_FIT_H
#define FFP_PIPELINE_FIT_H

#include <stdio.h>
#include "core/capture/capture.h"
#include "engine/refine/refine.h"
#include "ffprocams.h" // options and results, types alone (reconstruct.h says why)

// The target of a fit: the capture in the unit sphere, with noise filtered from the photographs under the
// patterns, of which the first two are black and white.
typedef struct FfpFitPhotographs {
    const FfpCapture *source, *capture;
    int patterns[FFP_PATTERNS_MAX], n_patterns;
    FILE *metrics; // NULL: none is asked for
} FfpFitPhotographs;

typedef struct FfpFitCall {
    const FfpCapture *capture;
    const FfpRefinement *options;
    bool goes_on; // resumes from a checkpoint: existing lines of metrics are kept
    bool (*work)(void *argument, const FfpFitPhotographs *photographs, FfpError *err);
    void *argument;
} FfpFitCall;
// Calls `work` with the photographs, and the file of metrics open.
bool ffp_fit_call(const FfpFitCall *fit, FfpError *err);

// Moves fitted Gaussians into world units, and adds the patterns to those that they were made from before.
// `stats` may be NULL.
void ffp_fit_done(FfpGaussians *gaussians, const char *made_from, const FfpFitPhotographs *photographs,
                  const FfpRefineResult *result, FfpRefinementStats *stats);

#endif
