// Where the common stage lies, from its pattern: what stands above the platter turns with it.
#ifndef FFP_RIG_PLACE_H
#define FFP_RIG_PLACE_H

#include "rig/masks/steps.h"

// Marks [height*width] the pixels whose look in *stage, which ffp_common_stage found, is not the stage but
// an object that looks the same from all sides. Depth is where the patterns explain the stage's pictures
// best: a plane sweep along the rays of the first view's camera, squared differences being means over some 5
// x 5 pixels. The platter is the greatest height along the turntable's axis (the world's z) at which half as
// much lies, no farther from the axis than the object's sphere reaches, as at the commonest height. A pixel
// is marked if it lies above the platter, if no place out of reach explains it half as well or most pixels
// around lie at its depth, and if its point is within the masks (coverage, 0 and 1) of all views, or marked
// there: only what is round is the object's at one place at all stops. Returns the share that the marks are
// of the mean mask; 0, with meaningless marks, without a
// pattern or a platter.
double ffp_place_above(unsigned char *marks, const FfpCapture *capture, const FfpEmptyStage *stage);

#endif
