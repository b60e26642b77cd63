// A calibration without a board: from what a camera at several places sees of the codes on anything.
#ifndef FFP_SELFCAL_SELFCAL_H
#define FFP_SELFCAL_SELFCAL_H

#include "core/base/error.h"
#include "ffprocams.h" // options and results, types alone (engine/pipeline/reconstruct.h says why)
#include "rig/selfcal/bundle.h"

// The work of ffp_self_calibrate (ffprocams.h). `stats` may be NULL.
bool ffp_self_calibration_run(const FfpSelfCalibration *options, FfpSelfCalibrationStats *stats,
                              FfpError *err);

// All devices of a bundle that has its tracks, told and judged. Errors: ffp_bundle_start's; fewer than two
// places are left; a focal length that they do not tell.
bool ffp_self_calibration_fit(FfpBundle *bundle, FfpError *err);

// COLMAP's text model in a new folder: cameras.txt (RADIAL), images.txt with a picture for each known place
// and calib.jpg, which is the projector, and points3D.txt. The world is the first known place's camera; every
// length is times `scale`.
bool ffp_self_calibration_write(const FfpBundle *bundle, double scale, const char *folder, FfpError *err);

#endif
