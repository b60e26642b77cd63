// The object's share of each pixel, from what white adds to black.
#ifndef FFP_RIG_MASK_H
#define FFP_RIG_MASK_H

#include <stdint.h>
#include "core/image/image.h"

// 1 where the projector's light reaches something, otherwise 0, from linear pictures of one size: the
// sRGB-encoded luminance (Rec. 709) of white - black, smoothed by 1 2 1, is divided into the three classes
// between which the variance is greatest (Otsu 1979, 256 bins), and the darkest is background. Then holes are
// filled (1 in *holes), and pieces below a twentieth of the largest dropped. Fails if white adds nothing
// anywhere.
bool ffp_mask_otsu(FfpImage *mask, FfpImage *holes, const FfpImage *black, const FfpImage *white,
                   const char *where, FfpError *err);

// Fills enclosed background of less than a two-hundredth of the largest piece; returns how many pixels.
int64_t ffp_mask_fill_specks(FfpImage *mask);

// Fills background that does not reach the picture's edge.
void ffp_mask_fill_holes(FfpImage *mask);
// Drops pieces that have less than a twentieth of the largest's pixels; those that have fewer than `least`.
void ffp_mask_drop_pieces(FfpImage *mask);
void ffp_mask_drop_specks(FfpImage *mask, int64_t least);

#endif
