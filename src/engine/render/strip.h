// Large pictures are drawn in strips: G-buffers take far more memory than what is kept of them.
#ifndef FFP_RENDER_STRIP_H
#define FFP_RENDER_STRIP_H

#include "core/capture/capture.h"

#define FFP_WHOLE_PIXELS 2e6 // up to which a picture is drawn at once
#define FFP_STRIP_PIXELS 1e6 // of a larger one, drawn at once
#define FFP_STRIP_MARGIN 8   // rows above and below it, drawn for their neighbours' sake (outline.h)

// Rows that are drawn at once: all of a picture that is not large.
static inline int ffp_strip_rows(const FfpCamera *camera) {
    if ((double)camera->width * camera->height <= FFP_WHOLE_PIXELS) return camera->height;
    const int rows = (int)(FFP_STRIP_PIXELS / camera->width);
    return rows < 1 ? 1 : rows > camera->height ? camera->height : rows;
}

// Rows from `top` on, `rows` of them or as many as are left: what a camera of fewer rows sees, whose
// principal point lies as much higher.
static inline FfpCamera ffp_strip_of(const FfpCamera *camera, int top, int rows) {
    FfpCamera strip = *camera;
    strip.height = rows < camera->height - top ? rows : camera->height - top;
    strip.cy -= (real)top;
    return strip;
}

#endif
