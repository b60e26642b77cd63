// Separate poses of every view, and focal lengths, from the views' surfaces and the pattern: a bundle
// adjustment (Triggs et al. 2000) whose points are the pixels' own triangulated surfaces.
#ifndef FFP_ALIGN_BUNDLE_H
#define FFP_ALIGN_BUNDLE_H

#include "engine/align/align.h"
#include "engine/match/match.h"

#define FFP_BUNDLE_VIEWS_MAX 64 // more make too many unknowns

typedef struct FfpBundleReport {
    double off; // root mean square distance of camera rays from the projector pixels that they see, projector
                // pixels
    double apart;             // and of surfaces of different views from each other, camera pixels
    double turned;            // root mean square rotation of the devices about an axis, radians
    double camera, projector; // factors of the focal lengths
} FfpBundleReport;

// One step: matches the capture (normalised) with its present devices, adjusts all of them by the
// Gauss-Newton method with the expected errors of `given` (the original views) as a prior, and changes the
// capture's devices. focal: the expected error of the two focal lengths, a share; 0: keep them. The report
// describes the state before the step. Errors: those of ffp_initialisation_new; more than
// FFP_BUNDLE_VIEWS_MAX views.
bool ffp_bundle_step(FfpCapture *capture, const FfpView *given, int active, const FfpPoseErrors *expected,
                     double focal, FfpBundleReport *report, FfpError *err);

#endif
