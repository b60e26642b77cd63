// Adaptive density: splats that the loss pulls at are doubled, those that nobody sees go.
#ifndef FFP_REFINE_DENSITY_H
#define FFP_REFINE_DENSITY_H

#include "base/rng.h"
#include "refine/fit.h"

typedef struct FfpCrowd { // what was seen of each Gaussian since the last change
    real *pull;           // [count] sum of the lengths of gradients in the picture
    int *seen;            // [count] views
    FfpRng rng;
} FfpCrowd;
FfpCrowd ffp_crowd_new(int64_t count, uint64_t seed);
void ffp_crowd_free(FfpCrowd *crowd);

// Notes a view's gradient to the Gaussians' centres [count,3], before it is pulled back.
void ffp_crowd_note(FfpCrowd *crowd, const FfpGaussians *gaussians, const FfpGaussians *grad,
                    const FfpCamera *camera);

// Clones, splits and takes away at the steps that `density` names, and resets opacities; `gaussians` are the
// decoded parameters. True when the number of Gaussians may have changed: everything else of that length
// must follow.
bool ffp_crowd_step(FfpCrowd *crowd, const FfpDensity *density, int64_t step, FfpParameters *parameters,
                    const FfpGaussians *gaussians, FfpMover *mover);

#endif
