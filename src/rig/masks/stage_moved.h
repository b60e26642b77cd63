// Whether the camera stands where the empty stage was photographed from.
#ifndef FFP_RIG_STAGE_MOVED_H
#define FFP_RIG_STAGE_MOVED_H

#include "core/image/image.h"

// The displacement (x, y) in pixels by which the stage's pictures look most like the view's; 0, 0 if none is
// clearly better than none. What white adds to black is compared, linear, 3 channels, all four of one size,
// by the mean of |a - b| / (a + b), at most 0.25 a pixel so that the object counts little, at displacements
// of up to 6 % of the width in pictures of about 160 pixels.
void ffp_stage_moved(int moved[2], const FfpImage *black, const FfpImage *white, const FfpImage *stage_black,
                     const FfpImage *stage_white);

#endif
