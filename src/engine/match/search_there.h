// The search for depth of all views on a device.
#ifndef FFP_MATCH_SEARCH_THERE_H
#define FFP_MATCH_SEARCH_THERE_H

#include "engine/match/match.h"
#include "engine/match/observe.h"

// True if the device can search the capture: no whole scene, without positions from Gray codes.
bool ffp_can_search_there(const FfpCapture *capture, const FfpMatchSettings *settings);

// Does for every view, on settings->device, what ffp_match_view does: depth and confidence [views,h,w], range
// [views,h,w,2], and the hulls, which the caller frees.
void ffp_search_there(real *depth, real *confidence, real *range, unsigned char **hulls,
                      const FfpCapture *capture, const FfpObservation *observed, const FfpBlurred *patterns,
                      const FfpMatchSettings *settings);

#endif
