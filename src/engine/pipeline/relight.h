// A view under a pattern, as stored in a file. Shared by rendering, evaluation and the report.
#ifndef FFP_PIPELINE_RELIGHT_H
#define FFP_PIPELINE_RELIGHT_H

#include "engine/network/network.h"
#include "engine/render/pass.h"
#include "ffprocams.h"

// The view drawn last under a pattern: sRGB-encoded RGB rounded to 8 bits, so that metrics see what the file
// will hold.
FfpImage ffp_relight(FfpViewPass *pass, const real intensity[3], const FfpSummed *pattern);

void ffp_quantise(FfpImage *encoded); // clamps to [0,1] and rounds to multiples of 1/255, in place

// The settings with which Gaussians are drawn: the model's own form if there is a model, and its samples
// unless the drawing gives others.
FfpRenderSettings ffp_drawing_settings(FfpDrawing drawing, const FfpModel *model);
// The same for pictures that are looked at, and not compared: outlines are smooth in the usual form.
FfpRenderSettings ffp_showing_settings(FfpDrawing drawing);

#endif
