// Masks that the light made, completed by what the views know of each other.
#ifndef FFP_RIG_GROW_MASKS_H
#define FFP_RIG_GROW_MASKS_H

#include <stdint.h>
#include "core/capture/capture.h"

// What the projector's light does not reach is missing from a mask made of it. A dark pixel of a view
// (`made`) becomes object where a part of its ray
// - lies in the shadow of the object, as far as it is known, or outside the projector's field, and
// - is possible to all other views: each shows light there, or has a shadow there too, and nearly all show
//   light.
// Holes that were filled (holes[v], as ffp_mask_otsu has them) stay filled where a part of the ray is what
// all other views show as object, and are opened elsewhere. The shadows are those of the visual hull
// (Laurentini 1994), which grows with them. Poses are known, bounds set. Returns how many pixels were added,
// less those opened.
bool ffp_grow_masks(FfpCapture *capture, const bool *made, const FfpImage *holes, int64_t *added);

#endif
