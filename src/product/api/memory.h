// Conversions between the public header's types for memory and the rooms' own.
#ifndef FFP_API_MEMORY_H
#define FFP_API_MEMORY_H

#include "core/capture/capture.h"
#include "core/image/raw.h"
#include "ffprocams.h"

FfpRaw ffp_raw_of(const FfpPicture *picture);

// Checks sides from `least`, focal lengths, finite numbers, and that the pose is rigid; makes it exactly so.
bool ffp_camera_of(FfpCamera *camera, const FfpPinhole *pinhole, int least, const char *name, FfpError *err);
FfpPinhole ffp_pinhole_of(const FfpCamera *camera);

#endif
