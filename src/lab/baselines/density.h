// Adaptive density (Kerbl et al. 2023, section 5): splats that the loss pulls at are doubled, those that
// nobody sees go.
#ifndef FFP_BASELINES_DENSITY_H
#define FFP_BASELINES_DENSITY_H

#include "core/base/rng.h"
#include "engine/refine/refine.h"

typedef struct FfpDensity {     // step numbers count from 1
    int64_t from, until, every; // steps of the additions
    int64_t reset_every;        // opacities are brought down to `reset_to`, until `until`
    real reset_to;
    real gradient; // of the loss to a splat's place in the picture, half a picture wide: above it splats are
                   // cloned or split
    real small;    // deviation up to which a splat is cloned, above it is split; in the Gaussians' unit
    real least_opacity; // splats below it are taken away
    int64_t most;       // Gaussians at which nothing is added any more
} FfpDensity;

typedef struct FfpDensityControl { // what was seen of each Gaussian since the last change
    FfpDensity density;
    real *pull; // [count] sum of the lengths of gradients in the picture
    int *seen;  // [count] views
    FfpRng rng;
} FfpDensityControl;
FfpDensityControl ffp_density_control_new(const FfpDensity *density, int64_t count, uint64_t seed);
void ffp_density_control_free(FfpDensityControl *density_control);

// The control at work in a fit: clones, splits and takes away at the steps that its density names, and resets
// opacities.
FfpGrowth ffp_density_growth(FfpDensityControl *density_control);

#endif
