// The single colour of each splat.
#ifndef FFP_EXPORT_LIGHT_H
#define FFP_EXPORT_LIGHT_H

#include "core/capture/capture.h"
#include "core/gaussians/gaussians.h"
#include "ffprocams.h"

// True if the options ask for light besides the ambient light.
bool ffp_export_lights(const FfpExport *options);
// Linear radiance of each Gaussian under the light that the options ask for, into colour [count,3].
bool ffp_export_bake(const FfpGaussians *gaussians, const FfpCapture *capture, const FfpExport *options,
                     real *colour, FfpError *err);

#endif
