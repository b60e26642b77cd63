// .splat: 32 bytes a splat.
#include <math.h>
#include <string.h>
#include "core/base/file.h"
#include "core/gaussians/elsewhere.h"

enum { ROW_BYTES = 32 };

static double get_float(const unsigned char *bytes) {
    const uint32_t bits =
        bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
    float value;
    memcpy(&value, &bits, sizeof value);
    return (double)value;
}

// Centre and scales as floats, then bytes: colour (sRGB), opacity, and w x y z of the rotation around 128.
static void get_row(const unsigned char bytes[ROW_BYTES], float row[FFP_ROW_NUMBERS]) {
    memset(row, 0, FFP_ROW_NUMBERS * sizeof *row);
    for (int k = 0; k < 3; k++) {
        row[FFP_ROW_POSITION + k] = (float)get_float(bytes + 4 * k);
        row[FFP_ROW_SCALE + k] = (float)log(get_float(bytes + 12 + 4 * k));
        row[FFP_ROW_AMBIENT + k] = (float)((bytes[24 + k] / 255.0 - 0.5) / FFP_SH_C0);
    }
    row[FFP_ROW_OPACITY] = (float)ffp_opacity_logit(bytes[27] / 255.0);
    for (int k = 0; k < 4; k++) row[FFP_ROW_ROTATION + k] = (float)(bytes[28 + k] - 128) / 128;
}

bool ffp_gaussians_read_splat(FfpGaussians *gaussians, const char *path, FfpError *err) {
    char *data;
    size_t size;
    *gaussians = (FfpGaussians){0};
    if (!ffp_read_file(path, FFP_SPLAT_FILE_MAX, &data, &size, err)) return false;
    const size_t count = size / ROW_BYTES;
    bool ok =
        (count > 0 || ffp_fail(err, FFP_ERROR_FILE, path,
                               "its %zu bytes are not rows of %d, as those of .splat", size, ROW_BYTES)) &&
        (count <= FFP_GAUSSIANS_MAX ||
         ffp_fail(err, FFP_ERROR_FILE, path, "%zu Gaussians are not in 0..%d", count, FFP_GAUSSIANS_MAX));
    if (ok) {
        FfpSplatSet set;
        ffp_splats_begin(&set, gaussians, (int64_t)count, path);
        for (size_t i = 0; i < count; i++) {
            float row[FFP_ROW_NUMBERS];
            get_row((const unsigned char *)data + ROW_BYTES * i, row);
            ffp_splats_add(&set, row);
        }
        ok = ffp_splats_end(&set, true, err);
        if (ok && size % ROW_BYTES) ffp_splats_note_rest(path, (int64_t)(size % ROW_BYTES));
    }
    ffp_free(data);
    return ok;
}
