// The loops of matching that exist once for each CPU level (core/base/level.h).
#ifndef FFP_MATCH_KERNELS_KERNELS_H
#define FFP_MATCH_KERNELS_KERNELS_H

#include "core/base/level.h"
#include "engine/match/blurred.h"
#include "engine/match/refine.h"
#include "engine/match/stereo.h"
#include "engine/match/surface.h"
#include "engine/match/sweep.h"

// ffp_fit_planes.
typedef void FfpFitPlanes(FfpPlane planes[FFP_MATCH_LANES], const FfpSheet *sheet, int x, int y);
// Inverse depth of the least cost among the hypotheses around the plane, `step` apart.
typedef real FfpRefinePixel(const FfpFineSearch *search, const FfpPlane *plane, int x, int y, real step);
// ffp_semi_global.
typedef void FfpSemiGlobal(real *total, const real *cost, const FfpForeground *foreground, int count,
                           const FfpSteps *steps);

// ffp_stereo_plane.
typedef void FfpSweepStereoPlane(real *single, const FfpStereoPlane *plane);

typedef struct FfpMatchKernels {
    FfpFitPlanes *fit_planes;
    FfpRefinePixel *refine_pixel;
    FfpSemiGlobal *semi_global;
    FfpSweepStereoPlane *stereo_plane;
} FfpMatchKernels;

FFP_LOOP_TABLES(FfpMatchKernels, match)

#ifdef FFP_LEVEL
FfpFitPlanes FFP_K(fit_planes);
FfpRefinePixel FFP_K(refine_pixel);
FfpSemiGlobal FFP_K(semi_global);
FfpSweepStereoPlane FFP_K(stereo_plane);
#endif

#endif
