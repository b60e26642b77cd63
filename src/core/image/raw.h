// Pictures in the caller's memory: one more kind of source besides the file formats.
#ifndef FFP_IMAGE_RAW_H
#define FFP_IMAGE_RAW_H

#include <stddef.h>
#include "core/image/image.h"

typedef enum FfpRawType {
    FFP_RAW_U8,  // sRGB-encoded, 0 to 255, straight alpha
    FFP_RAW_U16, // the same, 0 to 65535
    FFP_RAW_F32, // linear, premultiplied alpha
} FfpRawType;

typedef struct FfpRaw {
    const void *data; // rows from the top; NULL: no picture
    int width, height;
    int channels; // 1 grey, 3 RGB, 4 RGB and alpha
    FfpRawType type;
    size_t row_bytes; // from one row to the next; 0: rows are contiguous
} FfpRaw;

// Checks that sizes and strides are valid; `name` is for the message.
bool ffp_raw_check(const FfpRaw *raw, const char *name, FfpError *err);
// As ffp_image_read_over_black. Errors also: a value that is not finite.
bool ffp_raw_over_black(FfpImage *rgb, FfpImage *alpha, const FfpRaw *raw, const char *name, FfpError *err);
// The first channel unchanged (a mask, a depth): integers divided by the maximum of their type.
bool ffp_raw_channel(FfpImage *image, const FfpRaw *raw, const char *name, FfpError *err);

#endif
