#include "engine/match/kernels/kernels.h"
#include "engine/match/plane_formula.h"

void FFP_K(fit_planes)(FfpPlane planes[FFP_MATCH_LANES], const FfpSheet *sheet, int x, int y) {
    ffp_planes_at(planes, sheet, x, y);
}
