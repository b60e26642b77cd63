// Mistakes that make a reconstruction wrong: found before the work, and named with the view that they are in.
#ifndef FFP_RIG_SUSPECT_H
#define FFP_RIG_SUSPECT_H

#include "core/capture/capture.h"

// Looks at devices (behind or inside the object, in another unit or with other axes), at brightness
// (photographs exchanged or taken twice, a dark projector, an inverted mask), at silhouettes that contradict
// the others', and at how well structured light explains the photographs. What people do is tried: a view's
// photographs turned, mirrored or exchanged, a turntable that turned the other way, a picture mirrored by the
// projector, a calibration at another size, another pattern. Fails with FFP_ERROR_FAULT, naming view and
// remedy, where one of these explains what is wrong; what is doubtful but unexplained, and what only makes
// the result worse, is noted in the log.
bool ffp_rig_suspect(const FfpCapture *capture, FfpError *err);

#endif
