// A capture as the engine works on it: in its bounding sphere's units, its photographs without noise.
#ifndef FFP_PIPELINE_NORMALISED_H
#define FFP_PIPELINE_NORMALISED_H

#include "core/capture/capture.h"

// The capture in its bounding sphere's units, without copying pictures: it borrows everything but poses and
// depth from `capture`, which must outlive it. Release with ffp_normalised_alias_free, never with
// ffp_capture_free.
FfpCapture ffp_normalised_alias(const FfpCapture *capture);
void ffp_normalised_alias_free(FfpCapture *alias);

// Filters noise of standard deviation *noise, which is estimated and set if negative, from the n photographs
// (ffp_capture_photographs) of an alias. Returns the argument for ffp_denoise_free; NULL: nothing was
// changed.
FfpImage *ffp_denoise_capture(FfpCapture *alias, const int *photographs, int n, double *noise);

#endif
