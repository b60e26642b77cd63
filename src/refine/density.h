// Adaptive density: splats that the loss pulls at are doubled, those that nobody sees go.
#ifndef FFP_REFINE_DENSITY_H
#define FFP_REFINE_DENSITY_H

#include "base/rng.h"
#include "refine/fit.h"

typedef struct FfpDensityControl { // what was seen of each Gaussian since the last change
    real *pull;                    // [count] sum of the lengths of gradients in the picture
    int *seen;                     // [count] views
    FfpRng rng;
} FfpDensityControl;
FfpDensityControl ffp_density_control_new(int64_t count, uint64_t seed);
void ffp_density_control_free(FfpDensityControl *density_control);

// Notes a view's gradient to the Gaussians' centres [count,3], before it is pulled back.
void ffp_density_control_note(FfpDensityControl *density_control, const FfpGaussians *gaussians,
                              const FfpGaussians *grad, const FfpCamera *camera);

// Clones, splits and takes away at the steps that `density` names, and resets opacities; `gaussians` are the
// decoded parameters. True when the number of Gaussians may have changed: everything else of that length
// must follow.
bool ffp_density_control_step(FfpDensityControl *density_control, const FfpDensity *density, int64_t step,
                              FfpParameters *parameters, const FfpGaussians *gaussians, FfpMover *mover);

#endif
