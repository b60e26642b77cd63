// Reading and writing the rows. The file is little-endian whatever the machine is.
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include "core/base/arena.h"
#include "core/base/file.h"
#include "core/base/kind.h"
#include "core/gaussians/elsewhere.h"
#include "core/gaussians/ply_header.h"
#include "core/gaussians/row.h"

enum { BLOCK_ROWS = 1024 };

#define FLAT 0.01F // thickness of discs, as a share of their smaller radius

static float get_float(const unsigned char *bytes) {
    uint32_t bits = 0;
    for (int i = 0; i < 4; i++) bits |= (uint32_t)bytes[i] << (8 * i);
    float value;
    memcpy(&value, &bits, 4);
    return value;
}

static double get_double(const unsigned char *bytes) {
    uint64_t bits = 0;
    for (int i = 0; i < 8; i++) bits |= (uint64_t)bytes[i] << (8 * i);
    double value;
    memcpy(&value, &bits, 8);
    return value;
}

static void put_float(unsigned char *bytes, float value) {
    uint32_t bits;
    memcpy(&bits, &value, 4);
    for (int i = 0; i < 4; i++) bytes[i] = (unsigned char)(bits >> (8 * i));
}

typedef unsigned char RowBytes[4 * FFP_ROW_NUMBERS];

// Returns which number a reader would refuse, as the decoder knows; negative: none. It decodes the row into a
// Gaussian that nobody keeps.
static int print_row(const FfpGaussians *gaussians, int64_t index, RowBytes bytes) {
    real centre[3], scale[3], rotation[4], opacity, albedo[3], roughness, ambient[3];
    FfpGaussians one = {1, centre, scale, rotation, &opacity, albedo, &roughness, ambient, "", {{0}, 0}};
    float row[FFP_ROW_NUMBERS];
    ffp_row_encode(gaussians, index, row);
    for (int c = 0; c < FFP_ROW_NUMBERS; c++) put_float(bytes + 4 * c, row[c]);
    return ffp_row_decode(row, &one, 0);
}

// Rows in blocks, each of them printed by all threads.
static bool write_rows(FILE *stream, const FfpGaussians *gaussians, const char *path, real opacity_min,
                       FfpError *err) {
    enum { ROWS = 8 * BLOCK_ROWS };
    RowBytes *rows = ffp_take(ROWS, sizeof *rows);
    int *bad = ffp_take(ROWS, sizeof *bad);
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
            else if (fwrite(rows[r], sizeof rows[r], 1, stream) != 1)
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

static void get_row(const FfpPlyHeader *header, const unsigned char *bytes, float row[FFP_ROW_NUMBERS]) {
    for (int i = 0; i < FFP_ROW_NUMBERS; i++) {
        const unsigned char *at = bytes + header->offset[i];
        if (header->offset[i] < 0)
            row[i] = 0;
        else
            row[i] = header->wide >> i & 1U ? (float)get_double(at) : get_float(at);
    }
}

static void complete(FfpGaussians *gaussians, int64_t index, const FfpPlyHeader *header) {
    real *scale = gaussians->scale + 3 * index;
    if (header->flat) scale[2] = FLAT * (scale[0] < scale[1] ? scale[0] : scale[1]);
    if (header->plain) ffp_splat_complete(gaussians, index);
}

static bool read_rows(FfpGaussians *gaussians, const FfpPlyHeader *header, FILE *stream, const char *path,
                      FfpError *err) {
    const size_t stride = (size_t)header->stride;
    unsigned char *block = ffp_alloc(BLOCK_ROWS, stride);
    bool ok = true;
    for (int64_t done = 0; ok && done < header->count;) {
        const int64_t left = header->count - done, rows = left < BLOCK_ROWS ? left : BLOCK_ROWS;
        if (fread(block, stride, (size_t)rows, stream) != (size_t)rows)
            ok = ffp_fail(err, FFP_ERROR_IO, path, "cannot read all rows");
        for (int64_t r = 0; ok && r < rows; r++) {
            float row[FFP_ROW_NUMBERS];
            const int64_t index = done + r;
            get_row(header, block + (size_t)r * stride, row);
            const int bad = ffp_row_decode(row, gaussians, index);
            complete(gaussians, index, header);
            if (bad >= 0)
                ok = ffp_fail(err, FFP_ERROR_FILE, path, "Gaussian %lld: invalid %s", (long long)index,
                              ffp_row_names[bad]);
        }
        done += rows;
    }
    ffp_free(block);
    return ok;
}

// The rows must fill the file to its last byte, so that a count can never ask for more memory than the file's
// size warrants.
static bool check_size(const FfpPlyHeader *header, FILE *stream, const char *path, FfpError *err) {
    struct stat info;
    if (fstat(fileno(stream), &info) != 0 || !S_ISREG(info.st_mode))
        return ffp_fail(err, FFP_ERROR_FILE, path, "is not a regular file");
    const int64_t rest = (int64_t)info.st_size - (int64_t)ftello(stream),
                  want = header->count * header->stride;
    if (rest == want) return true;
    return ffp_fail(err, FFP_ERROR_FILE, path,
                    "%lld Gaussians of %d bytes need %lld bytes, but the file has %lld",
                    (long long)header->count, header->stride, (long long)want, (long long)rest);
}

static bool read_ply(FfpGaussians *gaussians, const char *path, FfpError *err) {
    FILE *stream = ffp_open_to_read(path, err);
    if (!stream) return false;
    ffp_own_file(stream);
    FfpPlyHeader header;
    bool ok = ffp_ply_header_read(&header, stream, path, err) && check_size(&header, stream, path, err);
    if (ok) {
        *gaussians = ffp_gaussians_new(header.count);
        memcpy(gaussians->made_from, header.made_from, sizeof header.made_from);
        gaussians->baked = header.baked;
        ok = read_rows(gaussians, &header, stream, path, err);
        if (ok && header.plain) ffp_splats_note(path);
        if (!ok) ffp_gaussians_free(gaussians);
    }
    ffp_close_file(stream);
    return ok;
}

bool ffp_gaussians_read(FfpGaussians *gaussians, const char *path, FfpError *err) {
    *gaussians = (FfpGaussians){0};
    if (!ffp_check_kind(path, FFP_WANTED_GAUSSIANS, err)) return false;
    switch (ffp_file_kind(path)) {
    case FFP_KIND_SPZ:
        return ffp_gaussians_read_spz(gaussians, path, err);
    case FFP_KIND_GLTF:
        return ffp_gaussians_read_gltf(gaussians, path, err);
    default:
        return read_ply(gaussians, path, err);
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

static bool read_header(FfpPlyHeader *header, const char *path, FfpError *err) {
    FILE *stream = ffp_open_to_read(path, err);
    if (!stream) return false;
    const bool ok = ffp_ply_header_read(header, stream, path, err);
    fclose(stream);
    return ok;
}

bool ffp_gaussians_read_made_from(char made_from[FFP_MADE_FROM], const char *path, FfpError *err) {
    FfpPlyHeader header;
    made_from[0] = 0;
    if (!ffp_check_kind(path, FFP_WANTED_GAUSSIANS, err)) return false;
    const FfpKind kind = ffp_file_kind(path);
    if (kind == FFP_KIND_SPZ || kind == FFP_KIND_GLTF) return true;
    if (!read_header(&header, path, err)) return false;
    memcpy(made_from, header.made_from, sizeof header.made_from);
    return true;
}

bool ffp_gaussians_are_relightable(const char *path) {
    FfpPlyHeader header;
    return read_header(&header, path, NULL) && !header.plain;
}
