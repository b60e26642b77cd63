// Reading an image file: take it into memory, see what it is, hand it to its codec.
#include <stdlib.h>
#include <tgmath.h>

#include "base/file.h"
#include "image/codec.h"

#define FILE_BYTES_MAX ((size_t)1 << 30)

bool ffp_check_sides(long long width, long long height, const char *path, FfpError *err) {
    if (width >= 1 && height >= 1 && width <= FFP_IMAGE_SIDE_MAX && height <= FFP_IMAGE_SIDE_MAX) return true;
    return ffp_fail(err, path, "image size %lld x %lld is outside 1..%d", width, height, FFP_IMAGE_SIDE_MAX);
}

static bool read_bytes(FfpBytes *file, const char *path, FfpError *err) {
    char *data = NULL;
    *file = (FfpBytes){.path = path};
    if (!ffp_read_file(path, FILE_BYTES_MAX, &data, &file->size, err)) return false;
    file->data = (const unsigned char *)data;
    if (file->size > 0) return true;
    free(data);
    ffp_fail(err, path, "file is empty");
    return false;
}

static void free_bytes(FfpBytes *file) {
    free((void *)file->data);
}

static bool not_an_image(const char *path, FfpError *err) {
    return ffp_fail(err, path, "is not a PNG, JPEG or EXR image");
}

static bool decode(FfpDecoded *out, const char *path, FfpError *err) {
    *out = (FfpDecoded){0};
    FfpBytes file;
    if (!read_bytes(&file, path, err)) return false;
    bool ok = false;
    if (ffp_png_is(&file))
        ok = ffp_png_decode(&file, out, err);
    else if (ffp_jpeg_is(&file))
        ok = ffp_jpeg_decode(&file, out, err);
    else if (ffp_exr_is(&file))
        ok = ffp_exr_decode(&file, out, err);
    else
        not_an_image(path, err);
    free_bytes(&file);
    return ok;
}

// Premultiplied to straight alpha; where alpha is 0 the colour stays as it is.
static void unpremultiply(FfpImage *image) {
    const ptrdiff_t pixels = (ptrdiff_t)image->width * image->height;
    for (ptrdiff_t i = 0; i < pixels; i++) {
        real *p = image->data + 4 * i;
        for (int c = 0; c < 3 && p[3] > 0; c++) p[c] /= p[3];
    }
}

bool ffp_image_read(FfpImage *image, const char *path, FfpColour colour, FfpError *err) {
    FfpDecoded decoded;
    *image = (FfpImage){0};
    if (!decode(&decoded, path, err)) return false;
    if (decoded.linear) unpremultiply(&decoded.image);
    if (decoded.linear && colour == FFP_COLOUR_ENCODED) ffp_image_to_srgb(&decoded.image);
    if (!decoded.linear && colour == FFP_COLOUR_LINEAR) ffp_image_to_linear(&decoded.image);
    *image = decoded.image;
    return true;
}

bool ffp_image_read_over_black(FfpImage *rgb, FfpImage *alpha, const char *path, FfpError *err) {
    FfpDecoded decoded;
    *rgb = (FfpImage){0};
    if (alpha != NULL) *alpha = (FfpImage){0};
    if (!decode(&decoded, path, err)) return false;
    FfpImage *image = &decoded.image;
    if (decoded.has_alpha && alpha != NULL) *alpha = ffp_image_channel(image, 3);
    if (decoded.linear) {
        // Premultiplied is over black already; alpha must not be multiplied in a second time.
        const ptrdiff_t pixels = (ptrdiff_t)image->width * image->height;
        for (ptrdiff_t i = 0; i < pixels; i++) image->data[4 * i + 3] = 1;
    }
    *rgb = ffp_image_over_black(image);
    if (!decoded.linear) ffp_image_to_linear(rgb);
    ffp_image_free(image);
    return true;
}

bool ffp_image_read_raw16(FfpImage *image, const char *path, FfpError *err) {
    *image = (FfpImage){0};
    FfpBytes file;
    if (!read_bytes(&file, path, err)) return false;
    bool ok = false;
    if (ffp_png_is(&file))
        ok = ffp_png_decode_raw(&file, image, err);
    else if (ffp_exr_is(&file))
        ok = ffp_exr_decode_raw(&file, image, err);
    else
        ffp_fail(err, path, "is not a grey PNG or an EXR image");
    free_bytes(&file);
    return ok;
}

bool ffp_image_read_size(int *width, int *height, const char *path, FfpError *err) {
    *width = *height = 0;
    FfpBytes file;
    if (!read_bytes(&file, path, err)) return false;
    bool ok = false;
    if (ffp_png_is(&file))
        ok = ffp_png_size(&file, width, height, err);
    else if (ffp_jpeg_is(&file))
        ok = ffp_jpeg_size(&file, width, height, err);
    else if (ffp_exr_is(&file))
        ok = ffp_exr_size(&file, width, height, err);
    else
        not_an_image(path, err);
    free_bytes(&file);
    return ok;
}
