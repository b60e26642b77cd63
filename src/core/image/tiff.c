// TIFF through libtiff: the first picture of a file, grey or RGB, of 1, 8 or 16 bits or floats.
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/call.h"
#include "core/image/profile.h"
#include "core/image/tiff_module.h"

#define RATIO_MAX 4096 // LZW, the densest of the compressions read, cannot shrink further
#define LIBTIFF_BYTES_MAX ((tmsize_t)1 << 30) // of one block that libtiff takes for itself

bool ffp_tiff_is(const FfpEncoded *file) {
    static const char *const magic[4] = {"II*\0", "MM\0*", "II+\0", "MM\0+"};
    for (int i = 0; i < 4; i++) {
        if (file->size >= 8 && memcmp(file->data, magic[i], 4) == 0) return true;
    }
    return false;
}

static const FfpTiffModule *load(FfpError *err) {
    static FfpModule module = {.name = "tiff",
                               .version = FFP_TIFF_MODULE_VERSION,
                               .purpose = "TIFF files are read by libtiff",
                               .origin = "the library itself: install ffprocams again"};
    return ffp_module_load(&module, err);
}

typedef struct Reading {
    const FfpTiffModule *lib;
    TIFF *tiff;
    const FfpEncoded *file;
    uint64_t position;
    char message[160]; // libtiff's first complaint
    uint32_t width, height;
    uint32_t block_width, block_height; // of a tile or strip
    bool tiled, separate;               // separate: a plane for each channel
    uint16_t bits, channels, colours;   // colours: 1 or 3; one more channel is alpha
    uint16_t orientation;
    bool floats, negative, premultiplied;
} Reading;

// --- The file as libtiff's stream. ---

static tmsize_t give_bytes(thandle_t user, void *to, tmsize_t count) {
    Reading *r = user;
    if (count <= 0 || r->position >= r->file->size) return 0;
    const uint64_t left = r->file->size - r->position,
                   given = (uint64_t)count < left ? (uint64_t)count : left;
    memcpy(to, r->file->data + r->position, given);
    r->position += given;
    return (tmsize_t)given;
}

static tmsize_t take_nothing(thandle_t user, void *from, tmsize_t count) {
    (void)user, (void)from, (void)count;
    return -1;
}

static toff_t seek(thandle_t user, toff_t offset, int whence) {
    Reading *r = user;
    r->position = whence == SEEK_SET ? offset : (whence == SEEK_CUR ? r->position : r->file->size) + offset;
    return r->position;
}

static int close_nothing(thandle_t user) {
    (void)user;
    return 0;
}

static toff_t give_size(thandle_t user) {
    return ((const Reading *)user)->file->size;
}

static int keep_error(TIFF *tiff, void *user, const char *module, const char *format, va_list arguments) {
    Reading *r = user;
    (void)tiff, (void)module;
    if (r->message[0] == 0) vsnprintf(r->message, sizeof r->message, format, arguments);
    return 1;
}

static int pass_warning(TIFF *tiff, void *user, const char *module, const char *format, va_list arguments) {
    (void)tiff, (void)user, (void)module, (void)format, (void)arguments; // e.g. of tags it does not know
    return 1;
}

static bool broken(const Reading *r, FfpError *err) {
    return ffp_fail(err, FFP_ERROR_FILE, r->file->path, "broken TIFF%s%s", r->message[0] != 0 ? ": " : "",
                    r->message);
}

static bool unsupported(const Reading *r, FfpError *err, const char *what) {
    return ffp_fail(
        err, FFP_ERROR_UNSUPPORTED, r->file->path,
        "TIFF %s, which is not supported: save it as grey or RGB with 8 or 16 bits or 32-bit floats", what);
}

// --- What the picture is. ---

// Raw photographs are TIFF files whose first picture is a small preview, or DNG, or still a colour filter's.
static bool is_raw(const Reading *r) {
    uint16_t count = 0, photometric = 0;
    uint32_t kind = 0;
    void *found = NULL;
    r->lib->get(r->tiff, TIFFTAG_SUBFILETYPE, &kind);
    r->lib->get(r->tiff, TIFFTAG_PHOTOMETRIC, &photometric);
    const bool preview =
        (kind & FILETYPE_REDUCEDIMAGE) != 0 && r->lib->get(r->tiff, TIFFTAG_SUBIFD, &count, &found);
    return preview || r->lib->get(r->tiff, TIFFTAG_DNGVERSION, &found) || photometric == PHOTOMETRIC_CFA ||
           photometric == 34892; // LinearRaw of DNG
}

static bool refuse_raw(const Reading *r, FfpError *err) {
    const char *make = NULL;
    const bool named = r->lib->get(r->tiff, TIFFTAG_MAKE, &make) && make;
    return ffp_fail(
        err, FFP_ERROR_UNSUPPORTED, r->file->path,
        "is a raw photograph (DNG, NEF, ARW or the like%s%.40s), which is not supported: develop it to a "
        "16-bit TIFF or PNG",
        named ? ", of " : "", named ? make : "");
}

static bool read_colours(Reading *r, FfpError *err) {
    uint16_t photometric = 0, compression = 0;
    if (!r->lib->get(r->tiff, TIFFTAG_PHOTOMETRIC, &photometric)) return broken(r, err);
    r->lib->get_or_default(r->tiff, TIFFTAG_COMPRESSION, &compression);
    switch (compression) {
    case COMPRESSION_NONE:
    case COMPRESSION_LZW:
    case COMPRESSION_PACKBITS:
    case COMPRESSION_DEFLATE:
    case COMPRESSION_ADOBE_DEFLATE:
        break;
    case COMPRESSION_JPEG:
        if (photometric == PHOTOMETRIC_YCBCR) {
            r->lib->set(r->tiff, TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
            photometric = PHOTOMETRIC_RGB;
        }
        break;
    default:
        return ffp_fail(err, FFP_ERROR_UNSUPPORTED, r->file->path,
                        "TIFF with compression %d, which is not supported: save it with LZW or Deflate",
                        compression);
    }
    r->negative = photometric == PHOTOMETRIC_MINISWHITE;
    r->colours = photometric == PHOTOMETRIC_RGB ? 3 : 1;
    return photometric == PHOTOMETRIC_RGB || photometric == PHOTOMETRIC_MINISBLACK || r->negative ||
           unsupported(r, err,
                       photometric == PHOTOMETRIC_SEPARATED ? "in CMYK"
                       : photometric == PHOTOMETRIC_PALETTE ? "with a palette"
                                                            : "with colours other than grey and RGB");
}

static bool read_channels(Reading *r, FfpError *err) {
    uint16_t format = 0, planes = 0, n_extra = 0;
    const uint16_t *extra = NULL;
    r->lib->get_or_default(r->tiff, TIFFTAG_BITSPERSAMPLE, &r->bits);
    r->lib->get_or_default(r->tiff, TIFFTAG_SAMPLEFORMAT, &format);
    r->lib->get_or_default(r->tiff, TIFFTAG_SAMPLESPERPIXEL, &r->channels);
    r->lib->get_or_default(r->tiff, TIFFTAG_PLANARCONFIG, &planes);
    r->lib->get_or_default(r->tiff, TIFFTAG_EXTRASAMPLES, &n_extra, &extra);
    r->lib->get_or_default(r->tiff, TIFFTAG_ORIENTATION, &r->orientation);
    r->separate = planes == PLANARCONFIG_SEPARATE && r->channels > 1;
    r->floats = format == SAMPLEFORMAT_IEEEFP;
    // a further channel that does not say what it is counts as straight alpha
    r->premultiplied = n_extra > 0 && extra[0] == EXTRASAMPLE_ASSOCALPHA;
    if (r->channels < r->colours || r->channels > r->colours + 1)
        return unsupported(r, err, "with channels beyond colour and alpha");
    if (r->floats)
        return r->bits == 32 ? !r->negative || broken(r, err)
                             : unsupported(r, err, "with 16- or 64-bit floats");
    if (format == SAMPLEFORMAT_INT || format == SAMPLEFORMAT_COMPLEXINT ||
        format == SAMPLEFORMAT_COMPLEXIEEEFP)
        return unsupported(r, err, "with signed or complex numbers");
    return r->bits == 8 || r->bits == 16 || (r->bits == 1 && r->channels == 1) ||
           unsupported(r, err, "with integers of neither 8 nor 16 bits");
}

// Bytes of a row of a tile or strip.
static size_t row_bytes(const Reading *r) {
    return ((size_t)r->block_width * (r->separate ? 1 : r->channels) * r->bits + 7) / 8;
}

static bool read_blocks(Reading *r, FfpError *err) {
    r->tiled = r->lib->is_tiled(r->tiff) != 0;
    if (r->tiled) {
        if (!r->lib->get(r->tiff, TIFFTAG_TILEWIDTH, &r->block_width) ||
            !r->lib->get(r->tiff, TIFFTAG_TILELENGTH, &r->block_height))
            return broken(r, err);
    } else {
        r->block_width = r->width;
        r->lib->get_or_default(r->tiff, TIFFTAG_ROWSPERSTRIP, &r->block_height);
        if (r->block_height > r->height) r->block_height = r->height;
    }
    if (!ffp_check_sides(r->block_width, r->block_height, r->file->path, err)) return false;
    const size_t row = row_bytes(r);
    const tmsize_t told = r->tiled ? r->lib->tile_row_size(r->tiff) : r->lib->scanline_size(r->tiff);
    if (told < 0 || (size_t)told != row) return broken(r, err);
    const size_t raw_bits = (size_t)r->width * r->height * r->channels * r->bits;
    return (row * r->block_height / RATIO_MAX <= r->file->size &&
            raw_bits / 8 / RATIO_MAX <= r->file->size) ||
           ffp_fail(err, FFP_ERROR_FILE, r->file->path, "truncated TIFF");
}

static void close_thing(void *tiff) {
    load(NULL)->close(tiff);
}

// r->tiff is to be closed whatever comes of it.
static bool begin_tiff(Reading *r, const FfpEncoded *file, FfpError *err) {
    *r = (Reading){.lib = load(err), .file = file};
    if (!r->lib) return false;
    TIFFOpenOptions *options = r->lib->options_new();
    if (!options) return ffp_fail(err, FFP_ERROR_MEMORY, file->path, "out of memory");
    r->lib->on_error(options, keep_error, r);
    r->lib->on_warning(options, pass_warning, r);
    r->lib->limit_memory(options, LIBTIFF_BYTES_MAX);
    r->tiff = r->lib->open(file->path, "rm", r, give_bytes, take_nothing, seek, close_nothing, give_size,
                           NULL, NULL, options);
    r->lib->options_free(options);
    if (!r->tiff) return broken(r, err);
    ffp_own(r->tiff, close_thing);
    return true;
}

static bool open_tiff(Reading *r, const FfpEncoded *file, FfpError *err) {
    if (!begin_tiff(r, file, err)) return false;
    if (is_raw(r)) return refuse_raw(r, err);
    if (!r->lib->get(r->tiff, TIFFTAG_IMAGEWIDTH, &r->width) ||
        !r->lib->get(r->tiff, TIFFTAG_IMAGELENGTH, &r->height))
        return broken(r, err);
    return ffp_check_sides(r->width, r->height, file->path, err) && read_colours(r, err) &&
           read_channels(r, err) && read_blocks(r, err);
}

static void close_tiff(Reading *r) {
    ffp_disown(r->tiff);
    if (r->tiff) r->lib->close(r->tiff);
}

// --- Pixels. ---

// Sample `index` of a row: an integer from 0 to 2^bits - 1, or a float.
static real sample_at(const Reading *r, const unsigned char *row, size_t index) {
    uint16_t word;
    float single;
    if (r->bits == 8) return (real)row[index];
    if (r->bits == 1) return (real)(row[index / 8] >> (7 - index % 8) & 1);
    if (r->bits == 16) {
        memcpy(&word, row + 2 * index, sizeof word);
        return (real)word;
    }
    memcpy(&single, row + 4 * index, sizeof single);
    return (real)single;
}

// Puts a block at (x, y) into `out` (as many channels as the file), whose rows may end before the block's.
static void place_block(const Reading *r, const unsigned char *block, uint32_t x, uint32_t y, uint16_t plane,
                        FfpImage *out) {
    const uint32_t columns = r->width - x < r->block_width ? r->width - x : r->block_width;
    const uint32_t rows = r->height - y < r->block_height ? r->height - y : r->block_height;
    const size_t channels = r->channels, here = r->separate ? 1 : channels;
    for (uint32_t j = 0; j < rows; j++) {
        const unsigned char *from = block + j * row_bytes(r);
        real *to = out->data + ((size_t)(y + j) * r->width + x) * channels + plane;
        for (uint32_t i = 0; i < columns; i++) {
            for (size_t c = 0; c < here; c++) to[i * channels + c] = sample_at(r, from, i * here + c);
        }
    }
}

static bool read_block(Reading *r, unsigned char *block, uint32_t x, uint32_t y, uint16_t plane) {
    const uint32_t left = r->height - y, rows = r->tiled || left > r->block_height ? r->block_height : left;
    const tmsize_t size = (tmsize_t)(rows * row_bytes(r));
    const tmsize_t got =
        r->tiled ? r->lib->read_tile(r->tiff, r->lib->tile_at(r->tiff, x, y, 0, plane), block, size)
                 : r->lib->read_strip(r->tiff, r->lib->strip_at(r->tiff, y, plane), block, size);
    return got == size;
}

// All channels as they are in the file.
static bool read_pixels(Reading *r, FfpImage *out, FfpError *err) {
    unsigned char *block = ffp_try_alloc(r->block_height, row_bytes(r));
    if (!block) return ffp_fail(err, FFP_ERROR_MEMORY, r->file->path, "out of memory");
    *out = ffp_image_new((int)r->width, (int)r->height, r->channels);
    bool ok = true;
    for (uint16_t plane = 0; ok && plane < (r->separate ? r->channels : 1); plane++) {
        for (uint32_t y = 0; ok && y < r->height; y += r->block_height) {
            for (uint32_t x = 0; ok && x < r->width; x += r->block_width) {
                ok = read_block(r, block, x, y, plane);
                if (ok) place_block(r, block, x, y, plane, out);
            }
        }
    }
    ffp_free(block);
    if (!ok) broken(r, err);
    const size_t count = (size_t)r->width * r->height * r->channels;
    for (size_t i = 0; ok && r->floats && i < count; i++) {
        if (!isfinite(out->data[i]))
            ok = ffp_fail(err, FFP_ERROR_FILE, r->file->path, "TIFF holds values that are not finite");
    }
    if (!ok) ffp_image_free(out);
    return ok;
}

// Floats are linear light, and premultiplied as in an EXR; integers are encoded, in [0,1], with straight
// alpha.
static void take_pixel(const Reading *r, const real *from, real *to) {
    const real top = r->floats ? 1 : (real)((1 << r->bits) - 1);
    const bool has_alpha = r->channels > r->colours;
    const real alpha = has_alpha ? from[r->colours] / top : 1;
    for (int c = 0; c < 3; c++) {
        real value = from[r->colours == 3 ? c : 0] / top;
        if (r->negative) value = 1 - value;
        if (r->floats && !r->premultiplied) value *= alpha;
        if (!r->floats && r->premultiplied) value = value < alpha ? value / alpha : alpha > 0;
        to[c] = value;
    }
    to[3] = alpha;
}

bool ffp_tiff_decode(const FfpEncoded *file, FfpDecoded *out, FfpError *err) {
    Reading r;
    FfpImage stored = {0};
    const bool ok = open_tiff(&r, file, err) && read_pixels(&r, &stored, err);
    uint32_t icc_size = 0;
    void *icc = NULL;
    if (ok && r.lib->get(r.tiff, TIFFTAG_ICCPROFILE, &icc_size, &icc) && icc)
        out->profile = ffp_profile_of_icc(icc, icc_size);
    close_tiff(&r);
    if (!ok) return false;
    const size_t pixels = (size_t)stored.width * (size_t)stored.height;
    out->image = ffp_image_new(stored.width, stored.height, 4);
    for (size_t i = 0; i < pixels; i++) take_pixel(&r, stored.data + i * r.channels, out->image.data + 4 * i);
    out->linear = r.floats;
    out->has_alpha = r.channels > r.colours;
    out->orientation = r.orientation;
    ffp_image_free(&stored);
    return true;
}

bool ffp_tiff_decode_raw(const FfpEncoded *file, FfpDecoded *out, FfpError *err) {
    Reading r;
    const bool ok = open_tiff(&r, file, err) &&
                    (r.channels == 1 || ffp_fail(err, FFP_ERROR_FILE, file->path, "is not a grey image")) &&
                    read_pixels(&r, &out->image, err);
    out->orientation = r.orientation;
    close_tiff(&r);
    return ok;
}

bool ffp_tiff_is_raw(const FfpEncoded *file) {
    Reading r;
    const bool raw = begin_tiff(&r, file, NULL) && is_raw(&r);
    close_tiff(&r);
    return raw;
}

bool ffp_tiff_size(const FfpEncoded *file, int *width, int *height, FfpError *err) {
    Reading r;
    const bool ok = open_tiff(&r, file, err);
    close_tiff(&r);
    if (!ok) return false;
    *width = (int)r.width;
    *height = (int)r.height;
    ffp_orient_size(width, height, r.orientation);
    return true;
}
