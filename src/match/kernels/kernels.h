// The loops of matching that exist once for each CPU level (base/level.h).
#ifndef FFP_MATCH_KERNELS_KERNELS_H
#define FFP_MATCH_KERNELS_KERNELS_H

#include "base/level.h"
#include "match/blurred.h"
#include "match/surface.h"
#include "match/sweep.h"

enum { FFP_REFINE_STEPS_MAX = 256 };

// ffp_fit_planes.
typedef void FfpFitPlanes(FfpPlane planes[FFP_MATCH_LANES], const FfpSheet *sheet, int x, int y);
// Inverse depth of the least cost among `steps` hypotheses around the plane, `step` apart.
typedef real FfpRefinePixel(const FfpView *view, const FfpObservation *seen, const FfpBlurred *patterns,
                            const FfpPlane *plane, int x, int y, int steps, real step);
// ffp_semi_global.
typedef void FfpSemiGlobal(real *total, const real *cost, const FfpForeground *foreground, int count,
                           real small, real large);

typedef struct FfpMatchKernels {
    FfpFitPlanes *fit_planes;
    FfpRefinePixel *refine_pixel;
    FfpSemiGlobal *semi_global;
} FfpMatchKernels;

FFP_LOOP_TABLES(FfpMatchKernels, match)

#ifdef FFP_LEVEL
FfpFitPlanes FFP_K(fit_planes);
FfpRefinePixel FFP_K(refine_pixel);
FfpSemiGlobal FFP_K(semi_global);
#endif

#endif
