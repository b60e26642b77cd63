// SPZ version 3 as Niantic published it (github.com/nianticlabs/spz, README): a header of 16 bytes and the
// attributes one after the other, gzipped. Axes: x right, y up, z backwards.
#include <math.h>
#include <zlib.h>
#include "core/base/file.h"
#include "core/gaussians/elsewhere.h"
#include "product/export/bytes.h"
#include "product/export/splats.h"

#define VERSION 3
#define SPLAT 20           // bytes: 9 of position, 1 of opacity, 3 of colour, 3 of scale, 4 of rotation
#define COUNT_MAX 10000000 // what readers of this version accept

static unsigned char byte_of(double value) {
    const double rounded = round(value);
    return (unsigned char)(rounded < 0 ? 0 : rounded > 255 ? 255 : rounded);
}

// Bits behind the point of 24-bit positions: as many as leave room for the farthest.
static int fraction_bits(const FfpSplats *splats, const char *path, int *bits, FfpError *err) {
    double most = 0;
    for (int64_t i = 0; i < 3 * splats->count; i++) most = fmax(most, fabs((double)splats->centre[i]));
    *bits = 20;
    while (*bits > 0 && ldexp(most, *bits) > 8388000) --*bits;
    return ldexp(most, *bits) <= 8388000 ||
           ffp_fail(err, FFP_ERROR_UNSUPPORTED, path,
                    "positions of up to %.3g do not fit the format's 24 bits: scale the capture", most);
}

static void put_position(unsigned char *bytes, const real *centre, int bits) {
    for (int k = 0; k < 3; k++) {
        const int32_t fixed = (int32_t)lround(ldexp((double)centre[k], bits));
        for (int b = 0; b < 3; b++) bytes[3 * k + b] = (unsigned char)((uint32_t)fixed >> (8 * b));
    }
}

// The three smaller parts, 10 bits each (sign and 9 bits of size), x y z w in order, behind the index of the
// largest; signs are turned so that the largest is positive.
static void put_rotation(unsigned char *bytes, const real *q) {
    const double xyzw[4] = {(double)q[1], (double)q[2], (double)q[3], (double)q[0]};
    uint32_t largest = 0;
    for (uint32_t i = 1; i < 4; i++)
        if (fabs(xyzw[i]) > fabs(xyzw[largest])) largest = i;
    uint32_t packed = largest;
    for (uint32_t i = 0; i < 4; i++) {
        if (i == largest) continue;
        const uint32_t negative = (xyzw[i] < 0) != (xyzw[largest] < 0);
        const uint32_t size = (uint32_t)(511 * fmin(fabs(xyzw[i]) / FFP_SPZ_SHORT, 1) + 0.5);
        packed = packed << 10 | negative << 9 | size;
    }
    ffp_put_u32(bytes, packed);
}

static void pack(const FfpSplats *splats, int bits, unsigned char *bytes) {
    const size_t n = (size_t)splats->count;
    unsigned char *position = bytes + FFP_SPZ_HEADER, *alpha = position + 9 * n, *colour = alpha + n,
                  *scale = colour + 3 * n, *rotation = scale + 3 * n;
    ffp_put_u32(bytes, FFP_SPZ_MAGIC);
    ffp_put_u32(bytes + 4, VERSION);
    ffp_put_u32(bytes + 8, (uint32_t)n);
    bytes[12] = 0, bytes[13] = (unsigned char)bits, bytes[14] = bytes[15] = 0; // no harmonics, no flags
    for (size_t i = 0; i < n; i++) {
        put_position(position + 9 * i, splats->centre + 3 * i, bits);
        put_rotation(rotation + 4 * i, splats->rotation + 4 * i);
        alpha[i] = byte_of((double)splats->opacity[i] * 255);
        for (size_t k = 3 * i; k < 3 * i + 3; k++) {
            const double dc = ((double)splats->colour[k] - 0.5) / FFP_SH_C0;
            colour[k] = byte_of(255 * (dc * FFP_SPZ_COLOUR + 0.5));
            scale[k] = byte_of((log((double)splats->scale[k]) + 10) * 16);
        }
    }
}

// deflate's memory is zlib's own, and nothing here jumps while it has some.
static bool zip(unsigned char *bytes, size_t size, unsigned char *out, size_t *out_size) {
    z_stream stream = {0};
    if (deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, 16 + MAX_WBITS, 9, Z_DEFAULT_STRATEGY) != Z_OK)
        return false;
    stream.next_in = bytes;
    stream.avail_in = (uInt)size;
    stream.next_out = out;
    stream.avail_out = (uInt)*out_size;
    const bool ok = deflate(&stream, Z_FINISH) == Z_STREAM_END;
    *out_size = stream.total_out;
    deflateEnd(&stream);
    return ok;
}

bool ffp_splats_write_spz(const FfpSplats *splats, const char *path, FfpError *err) {
    int bits = 0;
    if (splats->count > COUNT_MAX)
        return ffp_fail(err, FFP_ERROR_UNSUPPORTED, path,
                        "%lld Gaussians, but readers of SPZ accept up to %d", (long long)splats->count,
                        COUNT_MAX);
    if (!fraction_bits(splats, path, &bits, err)) return false;
    const size_t size = FFP_SPZ_HEADER + SPLAT * (size_t)splats->count;
    size_t zipped_size = size + size / 1000 + 4096;
    unsigned char *bytes = ffp_alloc(size, 1), *zipped = ffp_alloc(zipped_size, 1);
    pack(splats, bits, bytes);
    const bool ok = zip(bytes, size, zipped, &zipped_size)
                        ? ffp_write_file(path, zipped, zipped_size, err)
                        : ffp_fail(err, FFP_ERROR_IO, path, "cannot compress");
    ffp_free(bytes);
    ffp_free(zipped);
    return ok;
}
