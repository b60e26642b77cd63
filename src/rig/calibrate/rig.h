// The rig's own calibration.
#ifndef FFP_CALIBRATE_RIG_H
#define FFP_CALIBRATE_RIG_H

#include "core/base/error.h"
#include "ffprocams.h" // options and results, types alone (engine/pipeline/reconstruct.h says why)

// The work of ffp_calibrate_rig (ffprocams/rig.h). `stats` may be NULL.
bool ffp_calibration_run(const FfpRigCalibration *options, FfpRigCalibrationStats *stats, FfpError *err);

#endif
