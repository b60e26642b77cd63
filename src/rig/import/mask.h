// The object's share of each pixel, from what white adds to black.
#ifndef FFP_RIG_MASK_H
#define FFP_RIG_MASK_H

#include <stdint.h>
#include "core/image/image.h"

// 1 where the projector's light reaches something, else 0, from linear pictures of one size: sRGB-encoded
// luminance (Rec. 709) of white - black, smoothed by 1 2 1, in three classes between which the variance is
// greatest (Otsu 1979, 256 bins), the darkest being background. Then holes are filled, which *holes tells
// (1), and pieces below a twentieth of the largest dropped. Fails when white adds nothing anywhere.
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
