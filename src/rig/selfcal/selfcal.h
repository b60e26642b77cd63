// A calibration without a board: from what a camera sees of the codes, at several places or of a turntable.
#ifndef FFP_SELFCAL_SELFCAL_H
#define FFP_SELFCAL_SELFCAL_H

#include "core/base/error.h"
#include "ffprocams.h" // options and results, types alone (engine/pipeline/reconstruct.h says why)
#include "rig/selfcal/bundle.h"
#include "rig/selfcal/turning.h"

// The work of ffp_self_calibrate (ffprocams/rig.h). `stats` may be NULL.
bool ffp_self_calibration_run(const FfpSelfCalibration *options, FfpSelfCalibrationStats *stats,
                              FfpError *err);

// Reads the photographs of all places. A place whose photographs cannot be used gets a problem; errors: of
// all places, or of what was shown.
bool ffp_places_read(const FfpSelfCalibration *options, FfpTracks *tracks, FfpError *err);

// All devices of a bundle that has its tracks, told and judged. Errors: ffp_bundle_start's; fewer than two
// places are left; a focal length that they do not tell.
bool ffp_self_calibration_fit(FfpBundle *bundle, FfpError *err);

// All of a turntable that has its tracks and angles, judged likewise. Errors: those of ffp_turning_start,
// fewer than three sound stops, angles or numbers that the photographs do not tell.
bool ffp_self_calibration_turn(FfpTurning *turning, FfpError *err);
// The work of ffp_self_calibrate for a turntable whose tracks are read.
bool ffp_self_calibration_turntable(const FfpSelfCalibration *options, FfpTracks *tracks,
                                    FfpSelfCalibrationStats *stats, FfpError *err);

enum { FFP_FOCAL_35MM_LEAST = 5, FFP_FOCAL_35MM_MOST = 2000 };
// The focal length by the lens of photographs of this size: the one that is given or, if that is 0, the one
// that their files tell, with a note.
FfpKnownFocal ffp_known_focal(double focal_35mm, const FfpTracks *tracks);
// True if the focal length found contradicts the one that was known, which is then ignored: fit again, and
// report it by ffp_tell_known_focal.
bool ffp_judge_known_focal(FfpKnownFocal *known, double found);
void ffp_tell_known_focal(const FfpKnownFocal *known, double found);
// Checks that the logarithm of a device's focal length is certain enough. `doubt` is the rule of one that is
// nearly so; its advice is the error's too.
bool ffp_judge_focal(double log_focal, double deviation, const char *device, int doubt, FfpError *err);

// COLMAP's text model in a new folder: cameras.txt (RADIAL), images.txt with a picture for each known place
// and calib.jpg, which is the projector, and points3D.txt. The world is the first known place's camera; every
// length is times `scale`.
bool ffp_self_calibration_write(const FfpBundle *bundle, double scale, const char *folder, FfpError *err);

#endif
