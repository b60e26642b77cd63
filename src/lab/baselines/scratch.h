// Gaussians fitted to photographs without a prediction, the way GS-ProCams does it: points that grow, divide
// and vanish. The capture is normalised (object in the unit sphere) and so are the Gaussians.
#ifndef FFP_BASELINES_SCRATCH_H
#define FFP_BASELINES_SCRATCH_H

#include "lab/baselines/density.h"

typedef struct FfpScratchSettings {
    FfpRefineSettings fit; // its growth is what `density` says
    FfpDensity density;
    const FfpGaussians *given; // whose centres are the points to start from; NULL: points are drawn
    bool cube;      // in the cube [-1.3,1.3]^3, whatever the silhouettes say, instead of in the visual hull,
                    // where every view that sees a point has it inside its coverage
    int64_t points; // as many
} FfpScratchSettings;
// GS-ProCams' losses, rates and densification, for objects: a fit of a whole scene takes the cameras' own
// extent. `released`: everything as in its released program when it is given no points; otherwise points from
// the hull, and all of a view's pictures in each step.
FfpScratchSettings ffp_scratch_defaults(bool released);

// The points, given or drawn evenly: round splats as wide as the way to the three nearest, opacity 0.1, grey.
// Errors: an empty hull, three points or fewer, a device.
bool ffp_scratch_gaussians(FfpGaussians *gaussians, const FfpCapture *capture,
                           const FfpScratchSettings *settings, FfpError *err);

// ffp_refine_offered of such points, as what the Gaussians are then. From where there are points, cancelling
// keeps what there is, if the settings allow it.
bool ffp_scratch_fit(FfpGaussians *gaussians, const FfpCapture *capture, const int *patterns, int n_patterns,
                     const FfpScratchSettings *settings, FfpRefineResult *result, FfpError *err);

#endif
