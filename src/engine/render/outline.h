// Inside the render room: outlines of pictures that are finer than the photographs. Splats are about as wide
// as the photographs' pixels, so in finer pictures an outline shows its single splats, as a fringe. There the
// opacity is smoothed by two thirds of a splat's deviation, and made as steep again as the outline of
// something whole is in these pixels; pixels that are not covered whole take the missing part of their light
// from those around. The page has the same in resolve.frag.
#ifndef FFP_RENDER_OUTLINE_H
#define FFP_RENDER_OUTLINE_H

#include "core/capture/capture.h"
#include "core/gaussians/gaussians.h"
#include "core/image/image.h"
#include "engine/render/strip.h"

// How far outlines are smoothed in a camera's picture: a deviation in its pixels, or 0 where these are about
// as coarse as the photographs'.
real ffp_outline_deviation(const FfpGaussians *gaussians, const FfpCamera *camera);

// ffp_resolve of a picture of several samples a pixel (resolve.h), smoothed. On the CPU alone.
void ffp_resolve_smoothly(const FfpImage *mean, const real *opacity, int side, real deviation,
                          FfpImage *picture);

#endif
