// A fit from coarse to fine, for pictures too large for all steps at full size.
#ifndef FFP_REFINE_PYRAMID_H
#define FFP_REFINE_PYRAMID_H

#include "engine/refine/coarse.h"
#include "engine/refine/refine.h"

enum { FFP_PYRAMID_SIDE = 192 }; // pixels: the longer side up to which a picture needs no smaller one

// As ffp_refine under a limit in steps, with all of them where the pictures' longer side is reduced to
// FFP_PYRAMID_SIDE or less by halving it; half as many at each larger size, but no less than a quarter, in
// whole rounds. Coarse levels fit fewer and larger Gaussians (coarse.h). Every level cuts its pictures to the
// object and keeps shadow maps for some steps. Pictures that are small already, Gaussians that come from no
// pixels (origin->pixel NULL) and fewer steps than views: ffp_refine, to the bit. The result's steps are
// those of all levels together. Unless its rounds have clearly gained, it is judged on three views with one
// sample a pixel, and dropped where the Gaussians showed them better before. Errors: as ffp_refine; on a
// device, pictures that need smaller ones.
bool ffp_refine_pyramid(FfpGaussians *gaussians, const FfpOrigin *origin, const FfpCapture *capture,
                        const int *patterns, int n_patterns, const FfpRefineSettings *settings,
                        FfpRefineResult *result, FfpError *err);

// Pixels of the full picture that are one of the smallest, a side: a power of two.
int ffp_pyramid_side(const FfpCapture *capture);

// As ffp_photographs_psnr with one sample a pixel, on pictures reduced to FFP_PYRAMID_SIDE, by Gaussians that
// are as much fewer and larger: to compare predictions with, at a price that does not grow with the pictures.
// Of n predictions, which come from origins[n], into psnr[n]. Not for what was fitted at full size, whose
// splats do not average to those of a smaller picture.
void ffp_pyramid_psnr(const FfpGaussians *const *gaussians, const FfpOrigin *origins, int n,
                      const FfpCapture *capture, const int *patterns, int n_patterns,
                      const FfpRenderSettings *render, double *psnr);

#endif
