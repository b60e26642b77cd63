// Corrects a capture's poses from its own photographs (docs/design/architecture.md, "Alignment").
#ifndef FFP_ALIGN_ALIGN_H
#define FFP_ALIGN_ALIGN_H

#include <stdbool.h>
#include "core/capture/capture.h"

// The expected errors of the poses, of each device separately: standard deviations.
typedef struct FfpPoseErrors {
    double turn;  // about each axis of a device, radians
    double shift; // along each axis, as a share of the device's distance from the object
} FfpPoseErrors;

typedef struct FfpAlignSettings {
    FfpPoseErrors expected;
    double focal; // likewise of the focal lengths of camera and projector, a share; 0: keep them
    int steps;    // for views that are not a turntable's, each separately
    int rounds;   // of the search for the rotations that all views share
} FfpAlignSettings;
FfpAlignSettings ffp_align_defaults(void); // 0.2 degrees, and a thousandth; focal lengths stay

typedef struct FfpAlignReport { // statistics
    bool turntable;             // the poses are now those of a fixed rig around a turning object
    bool own;                 // each view received separate poses, and all of them focal lengths if asked for
    double turned;            // the rotation, root mean square about an axis, radians
    double off[2], apart[2];  // before and after: FfpBundleReport
    double camera, projector; // factors of the focal lengths
    double evened;            // rotation by sharing a pose, root mean square about an axis, radians
    double depth, across, side; // the camera's part of the rotations that all views share, radians: towards
                                // the projector and back, across that, and sideways with the projector
    double before, after;       // disagreement (photo_consistency.h)
} FfpAlignReport;

// Moves the poses of all views; the capture is normalised (object in the unit sphere). First, views of one
// fixed rig around a turning object share a common pose, unless the pictures then agree worse (by half a per
// cent). Other views get separate poses (bundle.h), and so do those of a turntable if focal lengths are to be
// found, provided that the pictures then agree better. Then one rotation of the camera and one of the
// projector, shared by all views, are searched for. Components that only move the object as a whole keep
// their given values. Poses are unchanged if nothing better is found. Errors: those of
// ffp_initialisation_new.
bool ffp_align(FfpCapture *capture, int active, const FfpAlignSettings *settings, FfpAlignReport *report,
               FfpError *err);

#endif
