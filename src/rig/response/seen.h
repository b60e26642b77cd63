// Inside the response room: what a camera's pixel sees of a pattern, where codes or matching tell the place.
#ifndef FFP_RIG_SEEN_H
#define FFP_RIG_SEEN_H

#include "core/capture/capture.h"
#include "core/image/lookup.h"

// The patterns whose photographs may be looked at: all but black, white and those that are held out. Their
// number; patterns: [FFP_PATTERNS_MAX].
int ffp_seen_patterns(const FfpCapture *capture, int *patterns);

typedef struct FfpSeenBox {
    real u, v, du, dv; // centre and size on the pattern, pixels; sizes are at least 1
} FfpSeenBox;

// The box that pixel (x, y) covers, from its neighbours' positions (FfpView.correspondence); false: not all
// are known.
bool ffp_seen_box(const FfpImage *map, int x, int y, FfpSeenBox *box);

// The pattern's mean colour through a Gaussian of this deviation (pixels of it) and the box.
void ffp_seen_through(const FfpSummed *pattern, const FfpSeenBox *box, real deviation, real out[3]);

#endif
