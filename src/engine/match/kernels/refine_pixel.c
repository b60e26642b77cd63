#include "engine/match/fine_formula.h"
#include "engine/match/kernels/kernels.h"

real FFP_K(refine_pixel)(const FfpFineSearch *search, const FfpPlane *plane, int x, int y, real step) {
    const int steps = search->steps;
    FfpCell channels[FFP_REFINE_STEPS_MAX];
    real cost[FFP_REFINE_STEPS_MAX];
    for (int k = 0; k < steps; k++) {
        channels[k] = (FfpCell){0};
        cost[k] = 0;
    }
    ffp_fine_costs(cost, channels, search, plane, x, y, (FfpFineSpan){0, steps, step});
    return plane->q0 + (ffp_fine_least(cost, steps) - (real)(steps / 2)) * step;
}
