// Labels of pixels that agree with those of the pixels around, as far as the picture shows one surface.
#ifndef FFP_MATCH_LABELS_H
#define FFP_MATCH_LABELS_H

#include "core/base/real.h"
#include "engine/match/foreground.h"

// Sums of the least costs of eight paths to each pixel and label (Hirschmüller 2008). A label other than that
// of the pixel before costs more the more alike the two pixels are; where they are too dark to tell, it costs
// the same everywhere. total, cost [foreground.count,labels]; colour [h,w,3]: encoded.
void ffp_labels_total(real *total, const real *cost, const FfpForeground *foreground, int labels,
                      const real *colour);

#endif
