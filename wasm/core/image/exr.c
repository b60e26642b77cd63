// The page has no OpenEXR: it knows such a file when it sees one.
#include <string.h>
#include "core/image/codec.h"

static bool refuse(const char *path, FfpError *err) {
    return ffp_fail(err, FFP_ERROR_UNSUPPORTED, path,
                    "EXR files need the program: the page reads PNG and JPEG");
}

bool ffp_exr_is(const FfpEncoded *file) {
    return file->size >= 4 && memcmp(file->data, "\x76\x2f\x31\x01", 4) == 0;
}

bool ffp_exr_size(const FfpEncoded *file, int *width, int *height, FfpError *err) {
    *width = *height = 0;
    return refuse(file->path, err);
}

bool ffp_exr_decode(const FfpEncoded *file, FfpDecoded *out, FfpError *err) {
    (void)out;
    return refuse(file->path, err);
}

bool ffp_exr_decode_raw(const FfpEncoded *file, FfpDecoded *out, FfpError *err) {
    (void)out;
    return refuse(file->path, err);
}

bool ffp_image_write_exr(const FfpImage *image, const char *path, FfpError *err) {
    (void)image;
    return refuse(path, err);
}
