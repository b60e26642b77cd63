// What fits to a capture's pictures share.
#ifndef FFP_API_REFINE_H
#define FFP_API_REFINE_H

#include <stdio.h>
#include "ffprocams.h"
#include "capture/capture.h"

// Black, white and the patterns to fit to, without doubles, into chosen (indices into the capture's); returns
// how many. -1 with an error where a view lacks one.
int ffp_refinement_patterns(const FfpCapture *capture, const FfpRefinement *options,
                            int chosen[FFP_PATTERNS_MAX], FfpError *err);

// Does the work with the file of metrics open (NULL: none is asked for), which grows line by line.
bool ffp_refinement_with_metrics(const FfpRefinement *options,
                                 bool (*work)(void *argument, FILE *metrics, FfpError *err), void *argument,
                                 FfpError *err);

#endif
