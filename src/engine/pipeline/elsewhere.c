#include "engine/pipeline/elsewhere.h"
#include "core/base/log.h"

#define FAR 1.5 // radii: bounds are estimated, and splats at an outline may lie outside

void ffp_note_elsewhere(const FfpGaussians *gaussians, const FfpCapture *capture) {
    const double reach = FAR * (double)capture->radius;
    double all = 0, outside = 0;
    if (capture->scene || !(reach > 0)) return;
    for (int64_t i = 0; i < gaussians->count; i++) {
        double square = 0;
        for (int k = 0; k < 3; k++) {
            const double away = (double)gaussians->centre[3 * i + k] - (double)capture->centre[k];
            square += away * away;
        }
        all += (double)gaussians->opacity[i];
        outside += square > reach * reach ? (double)gaussians->opacity[i] : 0;
    }
    if (2 * outside > all)
        ffp_note("%.0f %% of the Gaussians lie outside the sphere of %s: are they of this capture?",
                 100 * outside / all, capture->name);
}
