// Margins just outside the frames of a whole scene's cameras.
#ifndef FFP_PIPELINE_MARGINS_H
#define FFP_PIPELINE_MARGINS_H

#include "core/capture/capture.h"
#include "core/gaussians/gaussians.h"
#include "engine/match/match.h"

// Adds Gaussians around each view's frame, for a tenth of its width, where no view sees anything: surfaces go
// on as planes beyond the frame, and look as they do inside it, mirrored at its edge. A new camera beside the
// others then sees no hole there. Returns how many there are.
int64_t ffp_margins_add(FfpGaussians *gaussians, const FfpCapture *capture, const FfpInitialisation *start);

#endif
