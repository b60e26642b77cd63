// A pattern out of an image file.
#include <stdio.h>
#include <string.h>
#include "core/base/file.h"
#include "core/capture/capture.h"

bool ffp_pattern_read(FfpPattern *pattern, const char *path, const FfpCamera *projector, FfpFraming framing,
                      FfpError *err) {
    const int width = projector->width, height = projector->height;
    *pattern = (FfpPattern){.novel = true};
    if (!ffp_framed_check(path, width, height, err) ||
        !ffp_image_read_over_black(&pattern->image, NULL, path, err))
        return false;
    if (pattern->image.width != width || pattern->image.height != height) {
        ffp_framing_note(path, &pattern->image, width, height, framing);
        FfpImage fitted = ffp_image_framed(&pattern->image, width, height, framing);
        ffp_image_free(&pattern->image);
        pattern->image = fitted;
    }
    snprintf(pattern->name, sizeof pattern->name, "%s", ffp_basename(path));
    char *dot = strrchr(pattern->name, '.');
    if (dot && dot != pattern->name) *dot = 0;
    return true;
}
