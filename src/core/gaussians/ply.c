// Writing the rows, and reading whatever holds Gaussians. The file is little-endian whatever the machine is.
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/file.h"
#include "core/base/kind.h"
#include "core/gaussians/elsewhere.h"
#include "core/gaussians/ply_header.h"
#include "core/gaussians/row.h"

static void put_float(unsigned char *bytes, float value) {
    uint32_t bits;
    memcpy(&bits, &value, 4);
    for (int i = 0; i < 4; i++) bytes[i] = (unsigned char)(bits >> (8 * i));
}

typedef unsigned char RowBytes[4 * FFP_ROW_NUMBERS];

// Returns which number a reader would refuse; negative: none.
static int print_row(const FfpGaussians *gaussians, int64_t index, RowBytes bytes) {
    float row[FFP_ROW_NUMBERS];
    ffp_row_encode(gaussians, index, row);
    for (int c = 0; c < ffp_row_numbers(gaussians); c++) put_float(bytes + 4 * c, row[c]);
    return ffp_row_refused(row);
}

// Rows in blocks, each of them printed by all threads.
static bool write_rows(FILE *stream, const FfpGaussians *gaussians, const char *path, real opacity_min,
                       FfpError *err) {
    enum { ROWS = 8192 };
    RowBytes *rows = ffp_take(ROWS, sizeof *rows);
    int *bad = ffp_take(ROWS, sizeof *bad);
    const size_t bytes = 4 * (size_t)ffp_row_numbers(gaussians);
    bool ok = true;
    for (int64_t done = 0; ok && done < gaussians->count; done += ROWS) {
        const int64_t left = gaussians->count - done, n = left < ROWS ? left : ROWS;
#pragma omp parallel for schedule(static)
        for (int64_t r = 0; r < n; r++)
            if (!(gaussians->opacity[done + r] < opacity_min))
                bad[r] = print_row(gaussians, done + r, rows[r]);
        for (int64_t r = 0; ok && r < n; r++) {
            if (gaussians->opacity[done + r] < opacity_min) continue;
            if (bad[r] >= 0)
                ok = ffp_fail(err, FFP_ERROR_FILE, path, "refusing to write a Gaussian with an invalid %s",
                              ffp_row_names[bad[r]]);
            else if (fwrite(rows[r], bytes, 1, stream) != 1)
                ok = ffp_fail(err, FFP_ERROR_IO, path, "cannot write");
        }
    }
    ffp_free(bad);
    ffp_free(rows);
    return ok;
}

bool ffp_gaussians_write(const FfpGaussians *gaussians, const char *path, real opacity_min, FfpError *err) {
    int64_t kept = 0;
    for (int64_t i = 0; i < gaussians->count; i++) kept += !(gaussians->opacity[i] < opacity_min);
    FfpOutput out;
    if (!ffp_output_open(&out, path, err)) return false;
    ffp_ply_header_write(out.stream, kept, gaussians);
    if (!write_rows(out.stream, gaussians, path, opacity_min, err)) {
        ffp_output_abort(&out);
        return false;
    }
    return ffp_output_commit(&out, err);
}

bool ffp_gaussians_write_drawn(const FfpGaussians *gaussians, const char *path, FfpError *err) {
    bool any = false;
    for (int64_t i = 0; i < gaussians->count && !any; i++) any = gaussians->opacity[i] >= FFP_OPACITY_LEAST;
    if (!any) return ffp_fail(err, FFP_ERROR_ARGUMENT, path, "no Gaussian is opaque enough to be seen");
    return ffp_gaussians_write(gaussians, path, FFP_OPACITY_LEAST, err);
}

bool ffp_gaussians_read(FfpGaussians *gaussians, const char *path, FfpError *err) {
    *gaussians = (FfpGaussians){0};
    if (!ffp_check_kind(path, FFP_WANTED_GAUSSIANS, err)) return false;
    switch (ffp_file_kind(path)) {
    case FFP_KIND_SPZ:
        return ffp_gaussians_read_spz(gaussians, path, err);
    case FFP_KIND_GLTF:
        return ffp_gaussians_read_gltf(gaussians, path, err);
    case FFP_KIND_SPLAT:
        return ffp_gaussians_read_splat(gaussians, path, err);
    case FFP_KIND_PLY:
        return ffp_gaussians_read_ply(gaussians, path, err);
    default:
        return ffp_refuse_splats(path, err);
    }
}

FfpGaussians *ffp_gaussians_load(const char *path, FfpError *err) {
    FfpGaussians *gaussians = ffp_alloc(1, sizeof *gaussians);
    if (ffp_gaussians_read(gaussians, path, err)) {
        if (gaussians->count > 0) return gaussians;
        ffp_gaussians_free(gaussians);
        ffp_fail(err, FFP_ERROR_FILE, path, "holds no Gaussians: nothing to draw or refine");
    }
    ffp_free(gaussians);
    return NULL;
}
