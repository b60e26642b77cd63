// Splats that another program wrote may have other axes than the capture: y up, y down, or any other order.
#ifndef FFP_PIPELINE_AXES_H
#define FFP_PIPELINE_AXES_H

#include "core/capture/capture.h"
#include "core/gaussians/gaussians.h"

// Turns them about the world's origin, by a quaternion w x y z.
void ffp_gaussians_rotate(FfpGaussians *gaussians, const real turn[4]);
// From a file's axes with this direction up (y or -y, otherwise z) to a world with z up: the inverse of
// export.
void ffp_gaussians_stand(FfpGaussians *gaussians, bool y, bool minus_y);
// Of the 24 ways to name axes the one in which they fit the silhouettes and, by their own colours, the
// photographs under black of up to six views best; applied with a note if it is clearly better than the one
// they have. A note also if none fits, or two do alike. A whole scene has no silhouettes, and is left as it
// is. Errors: those of reading the photographs.
bool ffp_gaussians_find_axes(FfpGaussians *gaussians, const FfpCapture *capture, const char *path,
                             FfpError *err);

#endif
