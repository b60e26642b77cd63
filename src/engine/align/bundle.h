// Poses of every view by themselves, and focal lengths, from what the views' surfaces and the pattern say: a
// bundle adjustment (Triggs et al. 2000) whose points are the pixels' own triangulated surfaces.
#ifndef FFP_ALIGN_BUNDLE_H
#define FFP_ALIGN_BUNDLE_H

#include "engine/align/align.h"
#include "engine/match/match.h"

#define FFP_BUNDLE_VIEWS_MAX 64 // more make too many unknowns

typedef struct FfpBundleReport {
    double off; // root mean square by which camera rays pass what they show of the pattern, projector pixels
    double apart;             // and by which surfaces of different views lie apart, camera pixels
    double turned;            // root mean square turn of the devices about an axis, radians
    double camera, projector; // factors of the focal lengths
} FfpBundleReport;

// One step: matches the capture (normalised) as its devices are, adjusts all of them by the Gauss-Newton
// method with what is expected of their errors against `given` (the views as they came) as a prior, and
// changes the capture's devices. focal: the expected error of the two focal lengths, a share; 0: they stay.
// The report is of before the step. Errors: those of ffp_initialisation_new; more than FFP_BUNDLE_VIEWS_MAX
// views.
bool ffp_bundle_step(FfpCapture *capture, const FfpView *given, int active, const FfpPoseErrors *expected,
                     double focal, FfpBundleReport *report, FfpError *err);

#endif
