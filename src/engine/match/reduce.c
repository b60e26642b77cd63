#include "engine/match/reduce.h"
#include <tgmath.h>

#define MATCHED_PIXELS 32768.0 // of the object a view: 128 planes of costs for them take 38 MB

int ffp_reduction_of(double pixels) {
    const double factor = ceil(sqrt(pixels / MATCHED_PIXELS));
    return factor > 1 ? (int)factor : 1;
}

int ffp_reduction(const FfpCapture *capture) {
    double shown = 0;
    for (int v = 0; v < capture->n_views; v++) {
        const FfpImage *coverage = &capture->views[v].coverage;
        const size_t pixels = (size_t)coverage->width * (size_t)coverage->height;
        for (size_t i = 0; i < pixels; i++) shown += coverage->data[i] > 0;
    }
    return ffp_reduction_of(shown / capture->n_views);
}
