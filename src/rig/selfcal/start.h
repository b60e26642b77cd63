// A first arrangement of all devices, from nothing but who sees what.
#ifndef FFP_SELFCAL_START_H
#define FFP_SELFCAL_START_H

#include "rig/selfcal/bundle.h"

// Sets optics, poses and nearness of the bundle, which has its tracks: two places by their essential matrix
// (Nister 2004), the projector by a linear fit to the points that these two see (Abdel-Aziz and Karara 1971),
// every other place by the points that are known then. Places that fit nothing get a problem and stay
// unknown. False, too, where photographs lead nowhere, without an error: `refused` of the bundle says why.
bool ffp_bundle_start(FfpBundle *bundle, FfpError *err);

#endif
