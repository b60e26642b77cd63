// An object that turns before a fixed camera and projector: in the object's frame, both go round it.
#ifndef FFP_RIG_TURNTABLE_H
#define FFP_RIG_TURNTABLE_H

#include "ffprocams.h" // options, types alone
#include "rig/optics/calibration.h"

typedef struct FfpTurntable {
    double axis[3];  // unit vector, camera coordinates; the world's z points along it
    double point[3]; // any point of the axis, camera coordinates, the calibration's unit: the world's origin
    double zero[3];  // the world's x axis at angle 0, camera coordinates; all 0: towards the camera
    bool clockwise;  // angles are left-handed about the axis
    int count;
    double angles[FFP_VIEWS_MAX]; // degrees by which the object has turned at each stop
    bool named;                   // its stops are views of these names, and their angles were measured
    char views[FFP_VIEWS_MAX][FFP_NAME_MAX];
    bool left_out[FFP_VIEWS_MAX]; // those whose angle could not be
} FfpTurntable;

// True if the caller's settings have a turntable.
bool ffp_turntable_is_given(const FfpImportTurntable *given);
// Takes the caller's settings of one, with the JSON or YAML file that they name, {"axis", "point", "angles"}
// or {"axis", "point", "count", "step"}, and "zero", "clockwise", "views" and "left_out" where it has them;
// the axis at length 1. One that is to be found points up and stands before the camera until then. Errors: no
// direction, no angles, too many, numbers out of range.
bool ffp_turntable_take(FfpTurntable *turntable, const FfpImportTurntable *given, FfpError *err);

// Gives the fixed rig a stop for each angle. An object turned by angle a about axis u through p has the point
// X of its own frame at R(u,a) B X + p before the camera, B = [x y u] being a right-handed basis (x along
// `zero`); hence c2w = [B^T R(u,-a) | -B^T R(u,-a) p] and p2w = c2w p2c. Stops are called by
// their names, by their angle ("045"), or by their number where angles would not tell them apart.
bool ffp_turntable_apply(const FfpTurntable *turntable, FfpCalibration *calibration, FfpError *err);
// The poses of stops that exist already, by their angles; only axis and point are used. `reversed`: the
// object turned left-handed about the axis.
void ffp_turntable_place(const FfpTurntable *turntable, bool reversed, FfpCalibration *calibration);
// Both for a calibration: stops of the turntable, if one is given. Without one, a calibration without stops
// gets one, "000", whose world is the camera's frame.
bool ffp_turntable_settle(const FfpImportTurntable *given, FfpCalibration *calibration, FfpError *err);

// Finds the axis of a turntable from a capture's pictures (fit_axis.h; `given`: with a guess or without), and
// gives the stops and the views, which are masked, their poses. Says how good it is. Errors: as
// ffp_fit_axis; an axis about which the views contradict each other or the pattern.
bool ffp_turntable_find(const FfpImportTurntable *given, FfpCalibration *calibration, FfpCapture *capture,
                        FfpError *err);

#endif
