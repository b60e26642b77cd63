#include "engine/match/foreground.h"
#include <stdlib.h>
#include "core/base/arena.h"

FfpForeground ffp_foreground_new(const FfpImage *coverage) {
    const size_t area = (size_t)coverage->width * (size_t)coverage->height;
    FfpForeground out = {coverage->width, coverage->height, 0, ffp_alloc(area, sizeof(size_t)),
                         ffp_alloc(area, sizeof(size_t))};
    for (size_t i = 0; i < area; i++) {
        const bool shown = coverage->data[i] > 0;
        out.slot[i] = shown ? out.count : FFP_OFF;
        if (shown) out.pixel[out.count++] = i;
    }
    return out;
}

void ffp_foreground_free(FfpForeground *foreground) {
    ffp_free(foreground->pixel);
    ffp_free(foreground->slot);
    *foreground = (FfpForeground){0};
}
