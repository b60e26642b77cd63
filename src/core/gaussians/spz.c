// SPZ: a header of 16 bytes and the attributes one after the other, gzipped; in version 4 a header of 32
// bytes, extensions, a table of sizes and each attribute compressed by Zstandard.
#include <math.h>
#include <string.h>
#include <zlib.h>
#include "core/base/file.h"
#include "core/base/log.h"
#include "core/gaussians/affine.h"
#include "core/gaussians/elsewhere.h"
#include "core/gaussians/zstd_module.h"

#define VERSION_STREAMS 4 // attributes are streams of their own
#define HEADER_STREAMS 32 // bytes
#define HARMONICS_MAX 72  // bytes of a splat
#define HARMONICS_DEGREE 4
#define RATIO_MAX 1032                    // of deflate: no file grows by more
#define RATIO_ZSTD 43691                  // of Zstandard: a block of 128 KiB from three bytes
#define EXTENDED 2                        // the flag of files that have extensions
#define EXTENSIONS 4096                   // bytes of them that are looked at behind a gzipped file's splats,
#define EXTENSIONS_MOST ((size_t)1 << 20) // and that there may be
#define AXES 0xadbe0003U                  // the extension that says in which axes the splats are
enum { ATTRIBUTES = 5 };                  // without the harmonics

struct FfpSpz {
    const char *path;
    uint32_t version, count;
    int bits;         // behind the point of fixed positions
    int harmonics;    // degree
    bool extended;    // there are extensions
    FfpAffine to_own; // from the file's axes to those of SPZ
    const unsigned char *position, *alpha, *colour, *scale, *rotation;
    unsigned char *own; // what holds them
};

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

// Bytes of a splat's position, opacity, colour, scale and rotation.
static size_t bytes_of(const FfpSpz *spz, int attribute) {
    const size_t bytes[ATTRIBUTES] = {spz->version == 1 ? 6 : 9, 1, 3, 3, spz->version >= 3 ? 4 : 3};
    return bytes[attribute];
}

static size_t splat_bytes(const FfpSpz *spz) {
    size_t sum = 0;
    for (int a = 0; a < ATTRIBUTES; a++) sum += bytes_of(spz, a);
    return sum;
}

static size_t harmonics_bytes(const FfpSpz *spz) {
    return (size_t)(3 * spz->harmonics * (spz->harmonics + 2)) * spz->count;
}

// Extension AXES: x, y and z of the file in words of RUB (right, up, back), which are SPZ's own.
static void take_axes(FfpSpz *spz, uint32_t number) {
    static const char names[][4] = {"RUB", "LDB", "RDB", "LUB", "RUB", "LDF", "RDF", "LUF", "RUF",
                                    "LFD", "RFD", "LFU", "RFU", "LBD", "RBD", "LBU", "RBU"};
    static const char ways[] = "RUBLDF";
    if (number >= sizeof names / sizeof *names) {
        ffp_note("%s: axes of the unknown number %u are taken for x right, y up, z back",
                 ffp_basename(spz->path), (unsigned)number);
        return;
    }
    memset(&spz->to_own, 0, sizeof spz->to_own);
    for (int k = 0; k < 3; k++) {
        const int way = (int)(strchr(ways, names[number][k]) - ways);
        spz->to_own.a[3 * (way % 3) + k] = way < 3 ? 1 : -1;
    }
}

// Records of a kind, a length and as many bytes, one after the other.
static void read_extensions(FfpSpz *spz, const unsigned char *bytes, size_t size) {
    while (spz->extended && size >= 8 && get_u32(bytes + 4) <= size - 8) {
        const size_t length = get_u32(bytes + 4);
        if (get_u32(bytes) == AXES && length >= 4) take_axes(spz, get_u32(bytes + 8));
        bytes += 8 + length;
        size -= 8 + length;
    }
}

// `most`: the last version that is stored as this one is.
static bool read_header(FfpSpz *spz, const unsigned char *bytes, uint32_t most, FfpError *err) {
    if (get_u32(bytes) != FFP_SPZ_MAGIC)
        return ffp_fail(err, FFP_ERROR_FILE, spz->path, "is gzipped, but not SPZ");
    spz->version = get_u32(bytes + 4);
    spz->count = get_u32(bytes + 8);
    spz->harmonics = bytes[12];
    spz->bits = bytes[13];
    spz->extended = bytes[14] & EXTENDED;
    if (spz->harmonics > HARMONICS_DEGREE)
        return ffp_fail(err, FFP_ERROR_FILE, spz->path, "harmonics of degree %d are not in 0..%d",
                        spz->harmonics, HARMONICS_DEGREE);
    if (spz->version < 1 || spz->version > most)
        return ffp_fail(err, FFP_ERROR_UNSUPPORTED, spz->path, "SPZ of version %u%s: 1 to %d are read",
                        (unsigned)spz->version, spz->version == VERSION_STREAMS ? ", gzipped" : "",
                        VERSION_STREAMS);
    if (spz->count > FFP_GAUSSIANS_MAX)
        return ffp_fail(err, FFP_ERROR_FILE, spz->path, "%u Gaussians are not in 0..%d", (unsigned)spz->count,
                        FFP_GAUSSIANS_MAX);
    return spz->bits <= 23 || ffp_fail(err, FFP_ERROR_FILE, spz->path,
                                       "positions of 24 bits cannot have %d behind the point", spz->bits);
}

static void find_parts(FfpSpz *spz, const unsigned char *bytes) {
    const unsigned char **const parts[ATTRIBUTES] = {&spz->position, &spz->alpha, &spz->colour, &spz->scale,
                                                     &spz->rotation};
    for (int a = 0; a < ATTRIBUTES; a++) {
        *parts[a] = bytes;
        bytes += bytes_of(spz, a) * spz->count;
    }
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

// Versions 3 and 4: the three smaller parts, 10 bits each (sign and 9 bits of size), x y z w in order, behind
// the index of the largest, which is positive.
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

void ffp_spz_row(const FfpSpz *spz, int64_t at, float row[FFP_ROW_NUMBERS]) {
    const size_t i = (size_t)at;
    memset(row, 0, FFP_ROW_NUMBERS * sizeof *row);
    for (size_t k = 0; k < 3; k++) {
        row[FFP_ROW_POSITION + k] =
            (float)(spz->version == 1 ? get_half(spz->position + 2 * (3 * i + k))
                                      : get_fixed(spz->position + 3 * (3 * i + k), spz->bits));
        row[FFP_ROW_AMBIENT + k] = (float)((spz->colour[3 * i + k] / 255.0 - 0.5) / FFP_SPZ_COLOUR);
        row[FFP_ROW_SCALE + k] = (float)(spz->scale[3 * i + k] / 16.0 - 10);
    }
    row[FFP_ROW_OPACITY] = (float)ffp_opacity_logit(spz->alpha[i] / 255.0);
    if (spz->version >= 3)
        get_smallest_three(spz->rotation + 4 * i, row + FFP_ROW_ROTATION);
    else
        get_three(spz->rotation + 3 * i, row + FFP_ROW_ROTATION);
    if (spz->extended) ffp_affine_move(&spz->to_own, row);
}

int64_t ffp_spz_count(const FfpSpz *spz) {
    return spz->count;
}

bool ffp_spz_has_harmonics(const FfpSpz *spz) {
    return spz->harmonics > 0;
}

static bool fits(const FfpSpz *spz, size_t bytes, size_t ratio, size_t size, FfpError *err) {
    return bytes / ratio <= size ||
           ffp_fail(err, FFP_ERROR_FILE, spz->path, "%u Gaussians do not fit into its %zu bytes",
                    (unsigned)spz->count, size);
}

static bool read_zipped(FfpSpz *spz, const Zipped *zipped, FfpError *err) {
    unsigned char header[FFP_SPZ_HEADER] = {0};
    if (unzip(zipped, header, FFP_SPZ_HEADER, 0, NULL) != FFP_SPZ_HEADER)
        return ffp_fail(err, FFP_ERROR_FILE, spz->path, "is not an SPZ file");
    if (!read_header(spz, header, VERSION_STREAMS - 1, err)) return false;
    const size_t size = FFP_SPZ_HEADER + splat_bytes(spz) * spz->count,
                 behind = spz->extended ? size + harmonics_bytes(spz) : size, // where extensions begin
        end = spz->extended ? behind + EXTENSIONS : size;
    if (!fits(spz, behind, RATIO_MAX, zipped->size, err)) return false;
    bool whole = false;
    spz->own = ffp_alloc(end, 1);
    const size_t rest = (size_t)HARMONICS_MAX * spz->count + (spz->extended ? EXTENSIONS_MOST : 0),
                 got = unzip(zipped, spz->own, end, rest, &whole);
    if (got < size)
        return ffp_fail(err, FFP_ERROR_FILE, spz->path, "ends before its %u Gaussians do",
                        (unsigned)spz->count);
    if (!whole) return ffp_fail(err, FFP_ERROR_FILE, spz->path, "is damaged: its checksum differs");
    if (got > behind) read_extensions(spz, spz->own + behind, got - behind);
    return true;
}

static uint64_t get_u64(const unsigned char *bytes) {
    return get_u32(bytes) | (uint64_t)get_u32(bytes + 4) << 32;
}

static const FfpZstdModule *load_zstd(FfpError *err) {
    static FfpModule module = {.name = "zstd",
                               .version = FFP_ZSTD_MODULE_VERSION,
                               .purpose = "SPZ files of version 4 are read by Zstandard",
                               .origin = "the library itself: install ffprocams again"};
    return ffp_module_load(&module, err);
}

// Version 4. The table has the compressed and the full size of each stream, which follow it in its order.
static bool unpack_streams(const FfpSpz *spz, unsigned char *out, const unsigned char *bytes, size_t size,
                           FfpError *err) {
    const size_t streams = bytes[15], table = get_u32(bytes + 16);
    const FfpZstdModule *zstd = load_zstd(err);
    if (!zstd) return false;
    if (spz->count == 0) return true;
    if (streams < ATTRIBUTES || table < HEADER_STREAMS || table > size || 16 * streams > size - table)
        return ffp_fail(err, FFP_ERROR_FILE, spz->path, "its table of %zu streams lies outside the file",
                        streams);
    size_t at = table + 16 * streams;
    for (int a = 0; a < ATTRIBUTES; a++) {
        const size_t full = bytes_of(spz, a) * spz->count;
        const uint64_t packed = get_u64(bytes + table + 16 * (size_t)a);
        if (get_u64(bytes + table + 16 * (size_t)a + 8) != full || packed > size - at ||
            zstd->decompress(out, full, bytes + at, (size_t)packed) != full)
            return ffp_fail(err, FFP_ERROR_FILE, spz->path, "its stream %d does not hold %u Gaussians", a,
                            (unsigned)spz->count);
        out += full;
        at += (size_t)packed;
    }
    return true;
}

static bool read_streams(FfpSpz *spz, const unsigned char *bytes, size_t size, FfpError *err) {
    if (size < HEADER_STREAMS) return ffp_fail(err, FFP_ERROR_FILE, spz->path, "ends inside its header");
    const size_t full = splat_bytes(spz) * spz->count, table = get_u32(bytes + 16);
    if (!fits(spz, full, RATIO_ZSTD, size, err)) return false;
    spz->own = ffp_alloc(full, 1);
    if (!unpack_streams(spz, spz->own, bytes, size, err)) return false;
    if (table > HEADER_STREAMS && table <= size)
        read_extensions(spz, bytes + HEADER_STREAMS, table - HEADER_STREAMS);
    return true;
}

static bool read_plain(FfpSpz *spz, const unsigned char *bytes, size_t size, FfpError *err) {
    if (size < FFP_SPZ_HEADER) return ffp_fail(err, FFP_ERROR_FILE, spz->path, "ends inside its header");
    if (!read_header(spz, bytes, VERSION_STREAMS, err)) return false;
    if (spz->version == VERSION_STREAMS) return read_streams(spz, bytes, size, err);
    const size_t full = splat_bytes(spz) * spz->count, behind = full + harmonics_bytes(spz);
    size -= FFP_SPZ_HEADER;
    if (full > size)
        return ffp_fail(err, FFP_ERROR_FILE, spz->path, "ends before its %u Gaussians do",
                        (unsigned)spz->count);
    spz->own = ffp_alloc(full, 1);
    memcpy(spz->own, bytes + FFP_SPZ_HEADER, full);
    if (size > behind) read_extensions(spz, bytes + FFP_SPZ_HEADER + behind, size - behind);
    return true;
}

FfpSpz *ffp_spz_open(const void *bytes, size_t size, const char *path, FfpError *err) {
    const Zipped zipped = {bytes, size};
    FfpSpz *spz = ffp_alloc(1, sizeof *spz);
    *spz = (FfpSpz){.path = path, .to_own = {.a = {1, 0, 0, 0, 1, 0, 0, 0, 1}}};
    const bool zip = size > 0 && zipped.bytes[0] != 'N';
    const bool ok = zip ? read_zipped(spz, &zipped, err) : read_plain(spz, bytes, size, err);
    if (!ok || !spz->own) {
        ffp_spz_close(spz);
        return NULL;
    }
    find_parts(spz, spz->own + (zip ? FFP_SPZ_HEADER : 0));
    return spz;
}

void ffp_spz_close(FfpSpz *spz) {
    if (spz) ffp_free(spz->own);
    ffp_free(spz);
}

bool ffp_gaussians_read_spz(FfpGaussians *gaussians, const char *path, FfpError *err) {
    char *bytes;
    size_t size;
    FfpSplatSet set;
    *gaussians = (FfpGaussians){0};
    if (!ffp_read_file(path, FFP_SPLAT_FILE_MAX, &bytes, &size, err)) return false;
    FfpSpz *spz = ffp_spz_open(bytes, size, path, err);
    ffp_free(bytes);
    if (!spz) return false;
    ffp_splats_begin(&set, gaussians, spz->count, path);
    set.harmonics = spz->harmonics > 0;
    for (int64_t i = 0; i < spz->count; i++) {
        float row[FFP_ROW_NUMBERS];
        ffp_spz_row(spz, i, row);
        ffp_splats_add(&set, row);
    }
    ffp_spz_close(spz);
    return ffp_splats_end(&set, true, err);
}
