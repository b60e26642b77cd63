// Fewer splats where several views describe the same surface.
#ifndef FFP_REFINE_THIN_H
#define FFP_REFINE_THIN_H

#include "core/capture/capture.h"
#include "core/gaussians/gaussians.h"

// Removes splats that cannot be seen (opacity 0), those that repeat splats of a view with the same camera,
// and, unless `layers` is 0, those at places that other views' splats, finer ones first, already cover
// `layers` times (docs/design/architecture.md, "Thinning"). Splats that are then isolated are widened to
// close the surface.
//   gaussians  in the capture's frame, fewer than 2^31; the rows that stay, here and of `pixel`, keep their
//              order
//   pixel      [count] index (view * height + y) * width + x of the pixel whose ray each centre lies on; no
//              two of one pixel
//   trust      [views,height,width]: of two splats that repeat each other the one of more trust stays, of
//              equal ones the first
//   layers     0: all
// Views have one size. Returns how many were left out. The same for any number of threads.
int64_t ffp_thin(FfpGaussians *gaussians, int64_t *pixel, const FfpCapture *capture, const real *trust,
                 double layers);

#endif
