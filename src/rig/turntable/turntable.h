// An object that turns before a fixed camera and projector: in the object's frame, both go round it.
#ifndef FFP_RIG_TURNTABLE_H
#define FFP_RIG_TURNTABLE_H

#include "rig/optics/calibration.h"

typedef struct FfpTurntable {
    double axis[3];  // unit vector, camera coordinates; the world's z points along it
    double point[3]; // any point of the axis, camera coordinates, the calibration's unit: the world's origin
    double zero[3];  // the world's x axis at angle 0, camera coordinates; all 0: towards the camera
    bool clockwise;  // angles are left-handed about the axis
    int count;
    double angles[FFP_VIEWS_MAX]; // degrees by which the object has turned at each stop
} FfpTurntable;

// From a JSON or YAML file {"axis", "point", "angles"} or {"axis", "point", "count", "step"}, and "zero" and
// "clockwise" where it has them. A file of `calibrate` has an axis and no angles: count stays 0.
bool ffp_turntable_read(FfpTurntable *turntable, const char *path, FfpError *err);
// The same without an axis: those of the file are passed over, and it is unknown until it is found.
bool ffp_turntable_read_angles(FfpTurntable *turntable, const char *path, FfpError *err);
// The angles that are given, if any, instead of the file's; one or the other must be.
bool ffp_turntable_set_angles(FfpTurntable *turntable, const FfpTurntable *given, const char *path,
                              FfpError *err);
// No angles, and an axis that points up, before the camera.
FfpTurntable ffp_turntable_unknown(void);
// Brings the axis' direction to length 1. Errors: it has none, or the point is out of range.
bool ffp_turntable_check_axis(FfpTurntable *turntable, FfpError *err);
// Errors: no angle, too many, one out of range.
bool ffp_turntable_check_angles(const FfpTurntable *turntable, FfpError *err);

// Gives the fixed rig a stop for each angle. An object turned by angle a about axis u through p has the point
// X of its own frame at R(u,a) B X + p before the camera, B = [x y u] being a right-handed basis (x along
// `zero`); hence c2w = [B^T R(u,-a) | -B^T R(u,-a) p] and p2w = c2w p2c. Stops are called by
// their angle ("045"), or by their number where angles would not tell them apart.
bool ffp_turntable_apply(const FfpTurntable *turntable, FfpCalibration *calibration, FfpError *err);
// The poses of stops that exist already, by their angles; only axis and point are used. `reversed`: the
// object turned left-handed about the axis.
void ffp_turntable_place(const FfpTurntable *turntable, bool reversed, FfpCalibration *calibration);
// One stop, "000", whose world is the camera's frame.
bool ffp_single_stop(FfpCalibration *calibration, FfpError *err);

#endif
