// Which sizes a picture may have: at all, and where another says it.
#include "core/image/codec.h"

bool ffp_check_sides(long long width, long long height, const char *path, FfpError *err) {
    if (width >= 1 && height >= 1 && width <= FFP_IMAGE_SIDE_MAX && height <= FFP_IMAGE_SIDE_MAX) return true;
    return ffp_fail(err, FFP_ERROR_FILE, path, "image size %lld x %lld is outside 1..%d", width, height,
                    FFP_IMAGE_SIDE_MAX);
}

bool ffp_size_check(const FfpSize *size, int width, int height, const char *path, FfpError *err) {
    if (width == size->width && height == size->height) return true;
    return ffp_fail(err, FFP_ERROR_FILE, path, "image is %d x %d, but the %s in %s has %d x %d", width,
                    height, size->of, size->in, size->width, size->height);
}
