// What fits to a capture's pictures share.
#ifndef FFP_API_REFINE_H
#define FFP_API_REFINE_H

#include <stdio.h>
#include "ffprocams.h"

// Does the work with the file of metrics open (NULL: none is asked for), which grows line by line.
bool ffp_refinement_with_metrics(const FfpRefinement *options,
                                 bool (*work)(void *argument, FILE *metrics, FfpError *err), void *argument,
                                 FfpError *err);

#endif
