// The page has no libtiff: it knows such a file when it sees one.
#include <string.h>
#include "core/image/codec.h"

static bool refuse(const FfpEncoded *file, FfpError *err) {
    return ffp_fail(err, FFP_ERROR_UNSUPPORTED, file->path,
                    "TIFF files need the program: the page reads PNG and JPEG");
}

bool ffp_tiff_is(const FfpEncoded *file) {
    return file->size >= 8 && (memcmp(file->data, "II*", 4) == 0 || memcmp(file->data, "MM\0*", 4) == 0);
}

bool ffp_tiff_is_raw(const FfpEncoded *file) {
    (void)file;
    return false;
}

bool ffp_tiff_size(const FfpEncoded *file, int *width, int *height, FfpError *err) {
    *width = *height = 0;
    return refuse(file, err);
}

bool ffp_tiff_decode(const FfpEncoded *file, FfpDecoded *out, FfpError *err) {
    (void)out;
    return refuse(file, err);
}

bool ffp_tiff_decode_raw(const FfpEncoded *file, FfpDecoded *out, FfpError *err) {
    (void)out;
    return refuse(file, err);
}
