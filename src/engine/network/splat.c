#include "engine/network/splat.h"

void ffp_residual_base(FfpPixelBase *base, const FfpInitialisation *start, int64_t pixel) {
    base->t = start->t[pixel];
    const real u = ffp_splat_clamped((base->t - base->nearest) / FFP_SPLAT_REACH, -FFP_SPLAT_REACH_MARGIN,
                                     FFP_SPLAT_REACH_MARGIN);
    base->t_logit = log((1 + u) / (1 - u));
    base->footprint = start->footprint[pixel];
    base->opacity_logit =
        ffp_splat_logit(FFP_SPLAT_INITIAL_OPACITY * start->coverage[pixel], FFP_SPLAT_OPACITY_MARGIN);
    ffp_normal_frame(start->normal + 3 * pixel, base->frame);
    for (int i = 0; i < 3; i++) {
        base->albedo_logit[i] = ffp_splat_logit(start->albedo[3 * pixel + i], FFP_SPLAT_ALBEDO_MARGIN);
        base->ambient_logit[i] = ffp_splat_logit(start->ambient[3 * pixel + i], FFP_SPLAT_AMBIENT_MARGIN);
    }
}
