// Devices that orbit an object.
#ifndef FFP_PIPELINE_ORBIT_H
#define FFP_PIPELINE_ORBIT_H

#include "core/capture/capture.h"
#include "ffprocams.h"

// `count` views [count] (release with ffp_free): those of one full turn from `base`. The turn is about the
// capture's centre and the direction that is up in its pictures, the mean over the views. Views have no
// pictures.
FfpView *ffp_orbit_views(const FfpCapture *capture, const FfpView *base, FfpOrbit orbit, int count);

#endif
