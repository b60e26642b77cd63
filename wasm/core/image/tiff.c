// The page has no libtiff: it knows such a file when it sees one.
#include <string.h>
#include "core/image/codec.h"

static bool refuse(const FfpBytes *file, FfpError *err) {
    return ffp_fail(err, FFP_ERROR_UNSUPPORTED, file->path,
                    "TIFF files need the program: the page reads PNG and JPEG");
}

bool ffp_tiff_is(const FfpBytes *file) {
    return file->size >= 8 && (memcmp(file->data, "II*", 4) == 0 || memcmp(file->data, "MM\0*", 4) == 0);
}

bool ffp_tiff_is_raw(const FfpBytes *file) {
    (void)file;
    return false;
}

bool ffp_tiff_size(const FfpBytes *file, int *width, int *height, FfpError *err) {
    *width = *height = 0;
    return refuse(file, err);
}

bool ffp_tiff_decode(const FfpBytes *file, FfpDecoded *out, FfpError *err) {
    (void)out;
    return refuse(file, err);
}

bool ffp_tiff_decode_raw(const FfpBytes *file, FfpDecoded *out, FfpError *err) {
    (void)out;
    return refuse(file, err);
}
