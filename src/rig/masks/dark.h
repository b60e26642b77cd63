// The object in the dark: where nothing but it sends light to the camera.
#ifndef FFP_RIG_DARK_H
#define FFP_RIG_DARK_H

#include "rig/masks/stage.h"

// Masks (0 and 1) of views whose pictures are not masked yet: what is brighter, in the mean of all its
// pictures, than their background by five standard deviations of that, less pieces below a twentieth of the
// largest. Shadows of the projector show in them by the room's weak light and by light from the object
// itself. False, and no masks, unless the background of every view is dark and even: by less than a thirtieth
// of the object's light.
bool ffp_dark_masks(FfpImage *masks, const FfpCapture *capture);

// Whether pictures of the empty stage show nothing either.
bool ffp_dark_stage(const FfpCapture *capture, int view, const FfpEmptyStage *stage);

// Edges of coverage that ffp_dark_masks found, as soft as the camera's (soft_edges.h). Pictures stay as they
// are.
void ffp_dark_soften(const FfpCapture *capture, FfpView *view);

#endif
