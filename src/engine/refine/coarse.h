// Fewer, larger splats in place of many, whose changes are carried back.
#ifndef FFP_REFINE_COARSE_H
#define FFP_REFINE_COARSE_H

#include "core/gaussians/gaussians.h"

// The pixels that Gaussians come from, in views of one size.
typedef struct FfpOrigin {
    int views, width, height;
    const int64_t *pixel; // [count] (view height + y) width + x, of each Gaussian; no pixel has two
} FfpOrigin;

typedef struct FfpCoarse {
    FfpGaussians gaussians;
    int side;          // of the blocks of pixels, and
    int across, down;  // how many of them a view has
    int64_t *of_block; // [views,down,across] the block's Gaussian; -1: none
} FfpCoarse;

// A Gaussian for each block of side x side pixels that has any: of the Gaussians that lie near the block's
// most opaque one the means of place, size (times side), colours and roughness; the sum of their opacities
// over the block's pixels; the most opaque one's rotation.
FfpCoarse ffp_coarse_new(const FfpGaussians *fine, const FfpOrigin *origin, int side);
void ffp_coarse_free(FfpCoarse *coarse);

// Applies the change of the coarse Gaussians from `before` to the fine ones, interpolated bilinearly between
// the blocks whose Gaussians are near: a displacement, factors on the size, differences of logits, and a
// rotation in world axes.
void ffp_coarse_carry(const FfpCoarse *coarse, const FfpGaussians *before, const FfpOrigin *origin,
                      FfpGaussians *fine);

#endif
