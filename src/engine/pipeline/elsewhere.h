// Gaussians that are not of the capture they are drawn with.
#ifndef FFP_PIPELINE_ELSEWHERE_H
#define FFP_PIPELINE_ELSEWHERE_H

#include "core/capture/capture.h"
#include "core/gaussians/gaussians.h"

// Notes that most of what they show (by opacity) lies farther from the centre of the capture's sphere than
// one and a half of its radii. Another object of the same rig is not noticed; a whole scene, or a capture
// without a sphere, is not asked.
void ffp_note_elsewhere(const FfpGaussians *gaussians, const FfpCapture *capture);

#endif
