// SPZ: a header of 16 bytes and the attributes one after the other, gzipped.
#include <math.h>
#include <string.h>
#include <zlib.h>
#include "core/base/file.h"
#include "core/gaussians/elsewhere.h"

#define VERSION_MAX 3
#define HARMONICS_MAX 45 // bytes of a splat
#define RATIO_MAX 1032   // of deflate: no file grows by more

typedef struct Spz {
    uint32_t version, count;
    int bits; // behind the point of fixed positions
    const unsigned char *position, *alpha, *colour, *scale, *rotation;
} Spz;

static uint32_t get_u32(const unsigned char *bytes) {
    return bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}

static double get_half(const unsigned char *bytes) {
    const unsigned bits = bytes[0] | (unsigned)bytes[1] << 8, exponent = bits >> 10 & 31, part = bits & 1023;
    const double size = exponent == 31 ? (part ? NAN : INFINITY)
                        : exponent     ? ldexp(1024 + part, (int)exponent - 25)
                                       : ldexp(part, -24);
    return bits >> 15 ? -size : size;
}

static double get_fixed(const unsigned char *bytes, int bits) {
    const uint32_t raw = bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16;
    return ldexp((double)(int32_t)(raw << 8) / 256, -bits);
}

// --- Unzipping. inflate's memory is zlib's own, and nothing here jumps while it has some. ---

typedef struct Zipped {
    const char *bytes;
    size_t size;
} Zipped;

// The first `size` bytes; how many there were. `whole`, unless NULL: whether the data ends after at most
// `rest` more, and agrees with its checksum, which stands behind them.
static size_t unzip(const Zipped *zipped, unsigned char *out, size_t size, size_t rest, bool *whole) {
    unsigned char scratch[4096];
    z_stream stream = {0};
    size_t done = 0;
    int code = Z_OK;
    if (inflateInit2(&stream, 16 + MAX_WBITS) != Z_OK) return 0;
    while (code == Z_OK && (done < size || (whole && done <= size + rest))) {
        const bool wanted = done < size;
        const size_t in_left = zipped->size - stream.total_in,
                     out_left = wanted ? size - done : sizeof scratch;
        stream.next_in = (z_const Bytef *)zipped->bytes + stream.total_in;
        stream.avail_in = (uInt)(in_left < 1U << 30 ? in_left : 1U << 30);
        stream.next_out = wanted ? out + done : scratch;
        stream.avail_out = (uInt)(out_left < 1U << 30 ? out_left : 1U << 30);
        code = inflate(&stream, Z_NO_FLUSH);
        done = stream.total_out;
    }
    inflateEnd(&stream);
    if (whole) *whole = code == Z_STREAM_END;
    return done < size ? done : size;
}

// --- The parts. ---

static size_t position_bytes(const Spz *spz) {
    return spz->version == 1 ? 6 : 9;
}

static size_t rotation_bytes(const Spz *spz) {
    return spz->version == 3 ? 4 : 3;
}

static bool read_header(Spz *spz, const unsigned char *bytes, const char *path, FfpError *err) {
    if (get_u32(bytes) != FFP_SPZ_MAGIC)
        return ffp_fail(err, FFP_ERROR_FILE, path, "is gzipped, but not SPZ");
    spz->version = get_u32(bytes + 4);
    spz->count = get_u32(bytes + 8);
    spz->bits = bytes[13];
    if (spz->version < 1 || spz->version > VERSION_MAX)
        return ffp_fail(err, FFP_ERROR_UNSUPPORTED, path, "SPZ of version %u: 1 to %d are read",
                        (unsigned)spz->version, VERSION_MAX);
    if (spz->count > FFP_GAUSSIANS_MAX)
        return ffp_fail(err, FFP_ERROR_FILE, path, "%u Gaussians are not in 0..%d", (unsigned)spz->count,
                        FFP_GAUSSIANS_MAX);
    return spz->bits <= 23 || ffp_fail(err, FFP_ERROR_FILE, path,
                                       "positions of 24 bits cannot have %d behind the point", spz->bits);
}

static void find_parts(Spz *spz, const unsigned char *bytes) {
    const size_t n = spz->count;
    spz->position = bytes + FFP_SPZ_HEADER;
    spz->alpha = spz->position + position_bytes(spz) * n;
    spz->colour = spz->alpha + n;
    spz->scale = spz->colour + 3 * n;
    spz->rotation = spz->scale + 3 * n;
}

// Versions 1 and 2: x y z as bytes, w what is left of 1.
static void get_three(const unsigned char *bytes, float wxyz[4]) {
    double square = 0;
    for (int k = 0; k < 3; k++) {
        const double part = bytes[k] / 127.5 - 1;
        wxyz[1 + k] = (float)part;
        square += part * part;
    }
    wxyz[0] = (float)sqrt(fmax(1 - square, 0));
}

// Version 3: the three smaller parts, 10 bits each (sign and 9 bits of size), x y z w in order, behind the
// index of the largest, which is positive.
static void get_smallest_three(const unsigned char *bytes, float wxyz[4]) {
    uint32_t packed = get_u32(bytes);
    const int largest = (int)(packed >> 30);
    double xyzw[4] = {0}, square = 0;
    for (int i = 3; i >= 0; i--) {
        if (i == largest) continue;
        const double size = FFP_SPZ_SHORT * (packed & 511) / 511;
        xyzw[i] = packed >> 9 & 1 ? -size : size;
        square += size * size;
        packed >>= 10;
    }
    xyzw[largest] = sqrt(fmax(1 - square, 0));
    for (int i = 0; i < 4; i++) wxyz[i] = (float)xyzw[(i + 3) % 4];
}

static void get_row(const Spz *spz, size_t i, float row[FFP_ROW_NUMBERS]) {
    const double alpha = fmin(fmax(spz->alpha[i] / 255.0, 1e-6), 1 - 1e-6);
    memset(row, 0, FFP_ROW_NUMBERS * sizeof *row);
    for (size_t k = 0; k < 3; k++) {
        row[FFP_ROW_POSITION + k] =
            (float)(spz->version == 1 ? get_half(spz->position + 2 * (3 * i + k))
                                      : get_fixed(spz->position + 3 * (3 * i + k), spz->bits));
        row[FFP_ROW_AMBIENT + k] = (float)((spz->colour[3 * i + k] / 255.0 - 0.5) / FFP_SPZ_COLOUR);
        row[FFP_ROW_SCALE + k] = (float)(spz->scale[3 * i + k] / 16.0 - 10);
    }
    row[FFP_ROW_OPACITY] = (float)log(alpha / (1 - alpha));
    if (spz->version == 3)
        get_smallest_three(spz->rotation + 4 * i, row + FFP_ROW_ROTATION);
    else
        get_three(spz->rotation + 3 * i, row + FFP_ROW_ROTATION);
}

static bool read_parts(FfpGaussians *gaussians, Spz *spz, const Zipped *zipped, const char *path,
                       FfpError *err) {
    const size_t size = FFP_SPZ_HEADER + (position_bytes(spz) + 7 + rotation_bytes(spz)) * (size_t)spz->count;
    if (size / RATIO_MAX > zipped->size)
        return ffp_fail(err, FFP_ERROR_FILE, path, "%u Gaussians do not fit into its %zu bytes",
                        (unsigned)spz->count, zipped->size);
    unsigned char *bytes = ffp_alloc(size, 1);
    bool whole = false;
    bool ok = unzip(zipped, bytes, size, (size_t)HARMONICS_MAX * spz->count, &whole) == size ||
              ffp_fail(err, FFP_ERROR_FILE, path, "ends before its %u Gaussians do", (unsigned)spz->count);
    ok = ok && (whole || ffp_fail(err, FFP_ERROR_FILE, path, "is damaged: its checksum differs"));
    find_parts(spz, bytes);
    if (ok) *gaussians = ffp_gaussians_new(spz->count);
    for (size_t i = 0; ok && i < spz->count; i++) {
        float row[FFP_ROW_NUMBERS];
        get_row(spz, i, row);
        ok = ffp_splat_put(gaussians, (int64_t)i, row, path, err);
    }
    ffp_free(bytes);
    if (!ok) ffp_gaussians_free(gaussians);
    return ok;
}

bool ffp_gaussians_read_spz(FfpGaussians *gaussians, const char *path, FfpError *err) {
    unsigned char header[FFP_SPZ_HEADER] = {0};
    char *bytes;
    Zipped zipped;
    Spz spz = {0};
    *gaussians = (FfpGaussians){0};
    if (!ffp_read_file(path, FFP_SPLAT_FILE_MAX, &bytes, &zipped.size, err)) return false;
    zipped.bytes = bytes;
    const bool ok = (unzip(&zipped, header, FFP_SPZ_HEADER, 0, NULL) == FFP_SPZ_HEADER ||
                     ffp_fail(err, FFP_ERROR_FILE, path, "is not an SPZ file")) &&
                    read_header(&spz, header, path, err) && read_parts(gaussians, &spz, &zipped, path, err);
    ffp_free(bytes);
    if (ok) ffp_splats_note(path);
    return ok;
}
