// Where a fit of scattered light begins.
#ifndef FFP_PIPELINE_SCATTERED_H
#define FFP_PIPELINE_SCATTERED_H

#include "core/capture/capture.h"
#include "core/gaussians/gaussians.h"

// Gives all Gaussians the same little scattered light, a share of what white adds to the capture's lit pixels
// in the mean, if the photographs under the patterns [n] can tell more: scattered light is what is seen in
// the dark parts of a pattern, so each place must be dark in some and lit in others. Otherwise there is none.
void ffp_scattered_start(FfpGaussians *gaussians, const FfpCapture *capture, const int *patterns, int n);

#endif
