// What fits to a capture's pictures share.
#ifndef FFP_PIPELINE_FIT_H
#define FFP_PIPELINE_FIT_H

#include <stdio.h>
#include "core/capture/capture.h"
#include "engine/refine/refine.h"
#include "ffprocams.h" // options and results, types alone (reconstruct.h says why)

// What is fitted to: the capture in the unit sphere, without noise in the photographs under the patterns, of
// which the first two are black and white.
typedef struct FfpFitPhotographs {
    const FfpCapture *source, *capture;
    int patterns[FFP_PATTERNS_MAX], n_patterns;
    FILE *metrics; // NULL: none is asked for
} FfpFitPhotographs;

typedef struct FfpFitCall {
    const FfpCapture *capture;
    const FfpRefinement *options;
    bool goes_on; // from a checkpoint: lines of metrics that are there stay
    bool (*work)(void *argument, const FfpFitPhotographs *photographs, FfpError *err);
    void *argument;
} FfpFitCall;
// Calls `work` with the photographs, and the file of metrics open.
bool ffp_fit_call(const FfpFitCall *fit, FfpError *err);

// Gaussians that were fitted to photographs, into world units; the patterns join what they were made from
// before. `stats` may be NULL.
void ffp_fit_done(FfpGaussians *gaussians, const char *made_from, const FfpFitPhotographs *photographs,
                  const FfpRefineResult *result, FfpRefinementStats *stats);

#endif
