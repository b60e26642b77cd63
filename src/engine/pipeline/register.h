// Poses of devices found again from photographs of an object whose Gaussians are known.
#ifndef FFP_PIPELINE_REGISTER_H
#define FFP_PIPELINE_REGISTER_H

#include "core/capture/capture.h"
#include "core/gaussians/gaussians.h"
#include "ffprocams.h" // options and results, types alone (reconstruct.h says why)

// The work of ffp_align_poses with Gaussians, in place, from the photographs under one pattern, or all (-1);
// `capture` and `gaussians` in the same world. Each view's camera and projector are moved, six numbers each,
// until the photographs look as the Gaussians are drawn: least squares of sRGB-encoded pictures over black by
// Levenberg and Marquardt (numerics), from small pictures to whole ones, which widens the range from which it
// finds its way. A view that gets no better stays. `stats` may be NULL.
void ffp_registration_run(FfpCapture *capture, const FfpGaussians *gaussians, int pattern,
                          FfpAlignmentStats *stats);

#endif
