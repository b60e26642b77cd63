// An object that slipped on its turntable, or a rig that was bumped: views that have one surface among
// themselves and another than the views before.
#ifndef FFP_RIG_SLIP_H
#define FFP_RIG_SLIP_H

#include "core/capture/capture.h"

typedef struct FfpSlip {
    int compared;    // pairs of neighbouring views that show enough of the same surface
    int pairs;       // of these, whose surfaces do not meet, but would if the object had moved;
    int pair;        // first view of the clearest of them; -1: none
    int first, last; // the views in which it stands elsewhere; -1: no such views explain it
    double shift;    // by how much: of the sphere's centre, world units,
    double turn;     // and degrees about it; 0: no turn is needed
} FfpSlip;

// Matches each view by itself, in pictures of some 180 pixels, and compares the surfaces of views that follow
// one another, the last and the first among them. Of fewer than FFP_RIG_VIEWS_TO_ACCUSE views, and of views
// that do not go round the object in their order, it says nothing.
FfpSlip ffp_rig_slip(const FfpCapture *capture, int active);

#endif
