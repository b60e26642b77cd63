// Mistakes that make a reconstruction wrong: found before the work, and named with the view that they are in.
#ifndef FFP_RIG_SUSPECT_H
#define FFP_RIG_SUSPECT_H

#include "core/capture/capture.h"

// Looks for a device behind or inside the object, black and white exchanged, and views that contradict the
// others' silhouettes; of the latter it tries what people do: one view's photographs turned or mirrored, two
// views exchanged, all of them in the other direction. Fails with FFP_ERROR_ARGUMENT, naming view and remedy,
// where one of these explains what is wrong; what is doubtful but unexplained is noted in the log. Takes some
// milliseconds for a capture without fault.
bool ffp_rig_suspect(const FfpCapture *capture, FfpError *err);

#endif
