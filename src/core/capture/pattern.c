// A pattern out of an image file.
#include <stdio.h>
#include <string.h>
#include "core/base/file.h"
#include "core/base/log.h"
#include "core/capture/capture.h"

bool ffp_pattern_read(FfpPattern *pattern, const char *path, int width, int height, FfpError *err) {
    *pattern = (FfpPattern){.novel = true};
    if (!ffp_image_read_over_black(&pattern->image, NULL, path, err)) return false;
    if (pattern->image.width != width || pattern->image.height != height) {
        ffp_note("pattern %s: resized from %d x %d to the projector's %d x %d", path, pattern->image.width,
                 pattern->image.height, width, height);
        FfpImage resized = ffp_image_resize(&pattern->image, width, height);
        ffp_image_free(&pattern->image);
        pattern->image = resized;
    }
    snprintf(pattern->name, sizeof pattern->name, "%s", ffp_basename(path));
    char *dot = strrchr(pattern->name, '.');
    if (dot && dot != pattern->name) *dot = 0;
    return true;
}
