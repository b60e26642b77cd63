#include "core/image/raw.h"
#include <stdint.h>
#include <tgmath.h>

static size_t value_bytes(FfpRawType type) {
    return type == FFP_RAW_U8 ? 1 : type == FFP_RAW_U16 ? 2 : 4;
}

bool ffp_raw_check(const FfpRaw *raw, const char *name, FfpError *err) {
    const int sides[2] = {raw->width, raw->height};
    for (int i = 0; i < 2; i++)
        if (sides[i] < 1 || sides[i] > FFP_IMAGE_SIDE_MAX)
            return ffp_fail(err, FFP_ERROR_ARGUMENT, name, "image size %d x %d is outside 1..%d", raw->width,
                            raw->height, FFP_IMAGE_SIDE_MAX);
    if (raw->channels != 1 && raw->channels != 3 && raw->channels != 4)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, name, "%d channels: expected 1, 3 or 4", raw->channels);
    if ((unsigned)raw->type > FFP_RAW_F32)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, name, "unknown pixel type");
    const size_t bytes = value_bytes(raw->type), row = (size_t)raw->width * (size_t)raw->channels * bytes;
    if (raw->row_bytes != 0 && (raw->row_bytes < row || raw->row_bytes % bytes != 0))
        return ffp_fail(err, FFP_ERROR_ARGUMENT, name, "rows of %zu bytes do not hold %zu bytes of pixels",
                        raw->row_bytes, row);
    return true;
}

// A row's values as numbers: integers divided by their greatest value.
static bool read_row(real *out, const FfpRaw *raw, int y) {
    const size_t count = (size_t)raw->width * (size_t)raw->channels;
    const size_t stride = raw->row_bytes ? raw->row_bytes : count * value_bytes(raw->type);
    const unsigned char *row = (const unsigned char *)raw->data + (size_t)y * stride;
    bool finite = true;
    for (size_t i = 0; i < count; i++) {
        if (raw->type == FFP_RAW_U8)
            out[i] = (real)row[i] / 255;
        else if (raw->type == FFP_RAW_U16)
            out[i] = (real)((const uint16_t *)row)[i] / 65535;
        else
            out[i] = (real)((const float *)row)[i];
        finite = finite && isfinite(out[i]);
    }
    return finite;
}

static bool read_all(FfpImage *image, const FfpRaw *raw, const char *name, FfpError *err) {
    *image = ffp_image_new(raw->width, raw->height, raw->channels);
    for (int y = 0; y < raw->height; y++) {
        real *row = image->data + (size_t)y * (size_t)raw->width * (size_t)raw->channels;
        if (read_row(row, raw, y)) continue;
        ffp_image_free(image);
        return ffp_fail(err, FFP_ERROR_ARGUMENT, name, "row %d holds a value that is not finite", y);
    }
    return true;
}

bool ffp_raw_channel(FfpImage *image, const FfpRaw *raw, const char *name, FfpError *err) {
    FfpImage all;
    *image = (FfpImage){0};
    if (!ffp_raw_check(raw, name, err) || !read_all(&all, raw, name, err)) return false;
    *image = ffp_image_channel(&all, 0);
    ffp_image_free(&all);
    return true;
}

bool ffp_raw_over_black(FfpImage *rgb, FfpImage *alpha, const FfpRaw *raw, const char *name, FfpError *err) {
    FfpImage all;
    *rgb = (FfpImage){0};
    if (alpha) *alpha = (FfpImage){0};
    if (!ffp_raw_check(raw, name, err) || !read_all(&all, raw, name, err)) return false;
    const size_t pixels = (size_t)all.width * (size_t)all.height, n = (size_t)all.channels;
    *rgb = ffp_image_new(all.width, all.height, 3);
    const bool linear = raw->type == FFP_RAW_F32;
    for (size_t i = 0; i < pixels; i++) {
        const real *from = all.data + n * i;
        const real a = n == 4 && !linear ? from[3] : 1;
        for (size_t c = 0; c < 3; c++) rgb->data[3 * i + c] = from[n == 1 ? 0 : c] * a;
    }
    if (!linear) ffp_image_to_linear(rgb);
    if (alpha && n == 4) *alpha = ffp_image_channel(&all, 3);
    ffp_image_free(&all);
    return true;
}
