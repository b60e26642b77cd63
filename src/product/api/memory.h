// Conversions between the public headers' types for memory and the rooms' own.
#ifndef FFP_API_MEMORY_H
#define FFP_API_MEMORY_H

#include "core/capture/capture.h"
#include "core/gaussians/gaussians.h"
#include "core/image/raw.h"
#include "ffprocams.h"

FfpRaw ffp_raw_of(const FfpPicture *picture);

// Checks sides from `least`, focal lengths, finite numbers, and that the pose is rigid; makes it exactly so.
bool ffp_camera_of(FfpCamera *camera, const FfpPinhole *pinhole, int least, const char *name, FfpError *err);
// Count and range of every number, and no quaternion of length 0.
bool ffp_check_arrays(const FfpGaussianArrays *arrays, FfpError *err);
// The same arrays, not copied.
FfpGaussians ffp_gaussians_of(const FfpGaussianArrays *arrays);
FfpPinhole ffp_pinhole_of(const FfpCamera *camera);

#endif
