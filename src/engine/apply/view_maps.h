// Correspondences and light between one camera and one projector, as images.
#ifndef FFP_APPLY_VIEW_MAPS_H
#define FFP_APPLY_VIEW_MAPS_H

#include "core/image/named.h"
#include "engine/apply/procams.h"

typedef struct FfpViewMapStats {
    FfpRoundTrip trip; // from the camera to the projector and back
    double lit_share;  // of the projector's pixels that fall on the object
} FfpViewMapStats;

// Linear images called as the files are (docs/reference/formats/pictures.md): camera_to_projector,
// projector_to_camera, projector_sees, lit, incidence, density, resolution, illuminance.
FfpImages *ffp_view_maps(const FfpGaussians *gaussians, const FfpCapture *capture, const FfpView *view,
                         const FfpRenderSettings *settings, FfpViewMapStats *stats);

#endif
