// Edges of a mask as soft as the camera's.
#ifndef FFP_RIG_SOFT_EDGES_H
#define FFP_RIG_SOFT_EDGES_H

#include "rig/masks/stage.h"

// A mask of 0 and 1 gets shares of pixels along its outline, and what is not the object's there leaves the
// view's pictures. In each picture a pixel two steps or less from the outline shows a mean of the object
// inside and of the stage there, which is known and as bright here as it is outside; its share is that which
// explains all pictures best. Where both are alike, the mask stays as it is.
void ffp_soften_edges(const FfpCapture *capture, FfpView *view, const FfpEmptyStage *stage, double noise);
// The mask alone: pictures stay as they are.
void ffp_soften_mask(const FfpCapture *capture, FfpView *view, const FfpEmptyStage *stage, double noise);

#endif
