// Corrects a capture's poses from its own photographs (docs/design/architecture.md, "Alignment").
#ifndef FFP_ALIGN_ALIGN_H
#define FFP_ALIGN_ALIGN_H

#include <stdbool.h>
#include "core/capture/capture.h"

// What is expected to be wrong with the poses, each device by itself: deviations.
typedef struct FfpPoseErrors {
    double turn;  // about each axis of a device, radians
    double shift; // along each axis, as a share of the device's distance from the object
} FfpPoseErrors;

typedef struct FfpAlignSettings {
    FfpPoseErrors expected;
    double focal; // likewise of the focal lengths of camera and projector, a share; 0: they stay as they are
    int steps;    // of views that are not a turntable's, each by itself
    int rounds;   // of the search for what all views share
} FfpAlignSettings;
FfpAlignSettings ffp_align_defaults(void); // 0.2 degrees, and a thousandth; focal lengths stay

typedef struct FfpAlignReport { // how it went
    bool turntable;             // the poses are now those of a fixed rig around a turning object
    bool own;                   // each view got poses of its own, and all of them focal lengths if asked for
    double turned;              // turns that took, root mean square about an axis, radians
    double off[2], apart[2];    // before and after: FfpBundleReport
    double camera, projector;   // factors of the focal lengths
    double evened;              // turns that took, root mean square about an axis, radians
    double depth, across, side; // the camera's part of the turns that all views share, radians: towards the
                                // projector and back, across that, and sideways with the projector
    double before, after;       // disagreement (look.h)
} FfpAlignReport;

// Moves the poses of all views; the capture is normalised (object in the unit sphere). First, views of one
// fixed rig around a turning object share what is common to their poses, if the pictures agree no worse (by
// half a per cent) under that. Other views get poses of their own (bundle.h), and so do a turntable's where
// focal lengths are to be found, if the pictures agree better so. Then one turn of the camera and one of the
// projector, shared by all views, are searched for. What only moves the object as a whole stays as the poses
// given have it. Poses are left alone where nothing better was found. Errors: those of
// ffp_initialisation_new.
bool ffp_align(FfpCapture *capture, int active, const FfpAlignSettings *settings, FfpAlignReport *report,
               FfpError *err);

#endif
