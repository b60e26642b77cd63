// The page has no libjpeg: it writes PNG.
#include "core/image/image.h"

bool ffp_image_write_jpeg(const FfpImage *image, int quality, const char *path, FfpError *err) {
    (void)image, (void)quality;
    return ffp_fail(err, FFP_ERROR_UNSUPPORTED, path, "JPEG files need the program: the page writes PNG");
}
