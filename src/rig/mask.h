// The object's share of each pixel, from what white adds to black.
#ifndef FFP_RIG_MASK_H
#define FFP_RIG_MASK_H

#include "image/image.h"

// 1 where the projector's light reaches something, else 0, from linear pictures of one size: sRGB-encoded
// luminance (Rec. 709) of white - black, smoothed by 1 2 1, in three classes between which the variance is
// greatest (Otsu 1979, 256 bins), the darkest being background. Then holes are filled, and pieces below a
// twentieth of the largest dropped. *threshold, when not NULL, gets the encoded value in [0,1]. Fails when
// white adds nothing anywhere.
bool ffp_mask_otsu(FfpImage *mask, const FfpImage *black, const FfpImage *white, double *threshold,
                   const char *where, FfpError *err);

#endif
