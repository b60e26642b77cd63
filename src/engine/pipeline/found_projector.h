// A projector's place and lens from its Gray codes on an object whose Gaussians are known.
#ifndef FFP_PIPELINE_FOUND_PROJECTOR_H
#define FFP_PIPELINE_FOUND_PROJECTOR_H

#include "core/capture/capture.h"
#include "core/gaussians/gaussians.h"
#include "ffprocams.h" // results, types alone (reconstruct.h says why)

// The work of ffp_find_projector, in place: the projectors of all views, the panel and the intensity, from
// the views' correspondence and the depth of the Gaussians as their cameras see it; `capture` and `gaussians`
// in the same world. Before an object the projector keeps its place beside the camera, before a scene its
// place in the world. Errors: as ffp_resect; no view has Gray codes. `found` may be NULL.
bool ffp_found_projector(FfpCapture *capture, const FfpGaussians *gaussians, FfpFoundProjector *found,
                         FfpError *err);

#endif
