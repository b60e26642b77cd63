#include <string.h>
#include "core/base/alloc.h"
#include "rig/checks/suspect_parts.h"

FfpCapture ffp_rig_alias(const FfpCapture *capture) {
    FfpCapture alias = *capture;
    alias.views = ffp_alloc((size_t)capture->n_views, sizeof *alias.views);
    memcpy(alias.views, capture->views, (size_t)capture->n_views * sizeof *alias.views);
    return alias;
}

FfpImage ffp_rig_undone(const FfpImage *image, FfpRigMishap mishap) {
    const int w = image->width, h = image->height, n = image->channels;
    FfpImage out = ffp_image_new(w, h, n);
    for (int y = 0; y < h; y++)
        for (int x = 0; x < w; x++) {
            const int from[FFP_RIG_MISHAPS][2] = {[FFP_RIG_TURNED_HALF] = {w - 1 - x, h - 1 - y},
                                                  [FFP_RIG_TURNED_LEFT] = {y, w - 1 - x},
                                                  [FFP_RIG_TURNED_RIGHT] = {h - 1 - y, x},
                                                  [FFP_RIG_MIRRORED] = {w - 1 - x, y},
                                                  [FFP_RIG_FLIPPED] = {x, h - 1 - y}};
            memcpy(out.data + n * ((ptrdiff_t)y * w + x),
                   image->data + n * ((ptrdiff_t)from[mishap][1] * w + from[mishap][0]),
                   (size_t)n * sizeof *out.data);
        }
    return out;
}
