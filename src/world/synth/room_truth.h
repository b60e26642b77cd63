// The true calibration of a rig, as `calibrate` would have written it.
#ifndef FFP_SYNTH_ROOM_TRUTH_H
#define FFP_SYNTH_ROOM_TRUTH_H

#include "world/synth/bare_rig.h"

// Into the folder: calibration.xml (OpenCV's FileStorage: intrinsics with pixel centres at integers, five
// coefficients of each lens, X_projector = R X_camera + T in millimetres) and axis.json (the turntable's axis
// in the camera's frame, and the angles of `views` even stops), each a second time as true_... .
bool ffp_room_truth_write(const FfpBareRig *rig, int views, const char *folder, FfpError *err);

#endif
