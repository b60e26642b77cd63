// The page has no libjpeg: it knows such a file when it sees one.
#include "core/image/codec.h"

static bool refuse(const FfpBytes *file, FfpError *err) {
    return ffp_fail(err, FFP_ERROR_UNSUPPORTED, file->path,
                    "JPEG files need the program: the page reads PNG");
}

bool ffp_jpeg_is(const FfpBytes *file) {
    return file->size >= 3 && file->data[0] == 0xFF && file->data[1] == 0xD8 && file->data[2] == 0xFF;
}

bool ffp_jpeg_size(const FfpBytes *file, int *width, int *height, FfpError *err) {
    *width = *height = 0;
    return refuse(file, err);
}

bool ffp_jpeg_decode(const FfpBytes *file, FfpDecoded *out, FfpError *err) {
    (void)out;
    return refuse(file, err);
}
