// The file formats behind image.h. Each reader takes the whole file in memory; which one is asked is decided
// by content.
#ifndef FFP_IMAGE_CODEC_H
#define FFP_IMAGE_CODEC_H

#include <stddef.h>
#include "image/image.h"

typedef struct FfpDecoded {
    FfpImage image; // RGBA; in an EXR, linear and premultiplied; otherwise encoded, in [0,1], straight alpha
    bool linear;    // an EXR
    bool has_alpha;
} FfpDecoded;

// A file in memory; `path` is for error messages.
typedef struct FfpBytes {
    const unsigned char *data;
    size_t size;
    const char *path;
} FfpBytes;

bool ffp_png_is(const FfpBytes *file);
bool ffp_png_size(const FfpBytes *file, int *width, int *height, FfpError *err);
bool ffp_png_decode(const FfpBytes *file, FfpDecoded *out, FfpError *err);
bool ffp_png_decode_raw(const FfpBytes *file, FfpImage *out,
                        FfpError *err); // 1 channel of integers; grey files only

bool ffp_jpeg_is(const FfpBytes *file);
bool ffp_jpeg_size(const FfpBytes *file, int *width, int *height, FfpError *err);
bool ffp_jpeg_decode(const FfpBytes *file, FfpDecoded *out, FfpError *err);

bool ffp_exr_is(const FfpBytes *file);
bool ffp_exr_size(const FfpBytes *file, int *width, int *height, FfpError *err);
bool ffp_exr_decode(const FfpBytes *file, FfpDecoded *out, FfpError *err);
bool ffp_exr_decode_raw(const FfpBytes *file, FfpImage *out,
                        FfpError *err); // Z, else Y, else the first channel

// Refuses a side of 0 or above FFP_IMAGE_SIDE_MAX.
bool ffp_check_sides(long long width, long long height, const char *path, FfpError *err);

#endif
