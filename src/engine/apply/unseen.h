// Light where no camera sees what a projector lights.
#ifndef FFP_APPLY_UNSEEN_H
#define FFP_APPLY_UNSEEN_H

#include "core/image/image.h"

// levels: [projector's size, 4], three levels times a certainty, and the certainty, 0 where no camera sees
// what the pixel lights. There, where `lit` (1 channel) is above 0, they go on from those that are known: by
// push and pull (Gortler et al. 1996) over means of 2 x 2 pixels, fading to dark over a twentieth of the
// longer side, so that other seats see neither edges nor light far from what was asked for. The page does the
// same (view/pattern.frag).
void ffp_fill_unseen(FfpImage *levels, const FfpImage *lit);

#endif
