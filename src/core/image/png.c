// PNG through libpng. Its errors leave by longjmp: all that must survive the jump lives in a struct of the
// caller's.
#include <math.h>
#include <png.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>
#include "core/base/arena.h"
#include "core/base/file.h"
#include "core/image/codec.h"

#define DEFLATE_RATIO_MAX 1040 // deflate cannot shrink further than 1032 : 1

bool ffp_png_is(const FfpEncoded *file) {
    return file->size >= 8 && png_sig_cmp(file->data, 0, 8) == 0;
}

static unsigned long long big_endian32(const unsigned char *p) {
    return (unsigned long long)p[0] << 24 | (unsigned long long)p[1] << 16 | (unsigned long long)p[2] << 8 |
           p[3];
}

bool ffp_png_size(const FfpEncoded *file, int *width, int *height, FfpError *err) {
    if (file->size < 33 || memcmp(file->data + 12, "IHDR", 4) != 0)
        return ffp_fail(err, FFP_ERROR_FILE, file->path, "truncated PNG");
    const long long w = (long long)big_endian32(file->data + 16),
                    h = (long long)big_endian32(file->data + 20);
    if (!ffp_check_sides(w, h, file->path, err)) return false;
    *width = (int)w;
    *height = (int)h;
    return true;
}

// Memory for libpng, in which nothing may end but by its own jump.
static void *take_memory(png_structp png, png_alloc_size_t bytes) {
    void *memory = ffp_try_alloc(bytes, 1);
    bool *no_memory = png_get_mem_ptr(png);
    if (!memory) *no_memory = true;
    return memory;
}

static void give_memory(png_structp png, void *memory) {
    (void)png;
    ffp_free(memory);
}

typedef struct Reading {
    FfpEncoded file;
    size_t position;
    bool truncated; // it was the end of the file that stopped libpng,
    bool no_memory; // or that of the memory
    png_structp png;
    png_infop info;
    int width, height, channels, depth; // depth: 8 or 16 bits as delivered
    bool grey, has_alpha;               // as in the file
    unsigned char *pixels; // [height, width, channels] of depth bits, big endian; one row where that will do
    real *values;          // [height, width, 4] of [0,1], or [height, width] as they stand if `raw`
    bool raw;
    char message[160];
} Reading;

static void on_error(png_structp png, png_const_charp message) {
    char *text = png_get_error_ptr(png);
    snprintf(text, sizeof((Reading *)0)->message, "%s", message);
    png_longjmp(png, 1);
}

static void on_warning(png_structp png, png_const_charp message) {
    (void)png;
    (void)message; // e.g. a colour profile it does not like: of no concern here
}

static void give_bytes(png_structp png, png_bytep to, size_t count) {
    Reading *reading = png_get_io_ptr(png);
    if (count > reading->file.size - reading->position) {
        reading->truncated = true;
        png_error(png, "truncated PNG");
    }
    memcpy(to, reading->file.data + reading->position, count);
    reading->position += count;
}

// Asks libpng for 8 or 16 bits a channel; all kinds but grey ones when `raw` become RGB or RGBA.
// Returns the number of passes in which the rows come.
static int set_transformations(Reading *r) {
    const bool raw = r->raw;
    const int type = png_get_color_type(r->png, r->info);
    r->grey = (type & (PNG_COLOR_MASK_COLOR | PNG_COLOR_MASK_ALPHA)) == 0;
    const bool transparency = !raw && png_get_valid(r->png, r->info, PNG_INFO_tRNS) != 0;
    r->has_alpha = (type & PNG_COLOR_MASK_ALPHA) != 0 || transparency;
    if (type == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(r->png);
    if (r->grey && png_get_bit_depth(r->png, r->info) < 8) png_set_expand_gray_1_2_4_to_8(r->png);
    if (transparency) png_set_tRNS_to_alpha(r->png);
    if (!raw) png_set_gray_to_rgb(r->png);
    const int passes = png_set_interlace_handling(r->png);
    png_read_update_info(r->png, r->info);
    r->channels = png_get_channels(r->png, r->info);
    r->depth = png_get_bit_depth(r->png, r->info);
    return passes;
}

static void *take_pixels(Reading *r, size_t rows, size_t row) {
    void *memory = ffp_try_alloc(rows, row);
    if (!memory) {
        r->no_memory = true;
        png_error(r->png, "out of memory");
    }
    return memory;
}

static unsigned value_at(const Reading *r, const unsigned char *row, size_t index) {
    return r->depth == 16 ? (unsigned)(row[2 * index] << 8 | row[2 * index + 1]) : row[index];
}

static void convert_row(const Reading *r, const unsigned char *row, size_t y) {
    const size_t width = (size_t)r->width, n = (size_t)r->channels;
    const real scale = r->depth == 16 ? 65535 : 255;
    if (r->raw) {
        for (size_t x = 0; x < width; x++) r->values[y * width + x] = (real)value_at(r, row, n * x);
        return;
    }
    real *to = r->values + 4 * y * width;
    for (size_t x = 0; x < width; x++)
        for (size_t c = 0; c < 4; c++) to[4 * x + c] = c < n ? (real)value_at(r, row, x * n + c) / scale : 1;
}

// In one pass a row at a time; interlaced pictures are taken as a whole.
static void read_rows(Reading *r, int passes) {
    const size_t stride = png_get_rowbytes(r->png, r->info), height = (size_t)r->height;
    const bool single = passes == 1;
    r->values = take_pixels(r, height, (size_t)r->width * (r->raw ? 1 : 4) * sizeof *r->values);
    r->pixels = take_pixels(r, single ? 1 : height, stride);
    for (int pass = 0; pass < passes; pass++)
        for (size_t y = 0; y < height; y++) {
            unsigned char *row = r->pixels + (single ? 0 : y * stride);
            png_read_row(r->png, row, NULL);
            if (pass == passes - 1) convert_row(r, row, y);
        }
}

static bool read_pixels(Reading *r) {
    r->png = png_create_read_struct_2(PNG_LIBPNG_VER_STRING, r->message, on_error, on_warning, &r->no_memory,
                                      take_memory, give_memory);
    r->info = r->png ? png_create_info_struct(r->png) : NULL;
    if (!r->info) return false;
    if (setjmp(png_jmpbuf(r->png))) return false;
    png_set_read_fn(r->png, r, give_bytes);
    png_read_info(r->png, r->info);
    // of the rows as they are in the file, with a byte for each row's filter
    const size_t raw_bytes = (1 + png_get_rowbytes(r->png, r->info)) * (size_t)r->height;
    if (raw_bytes / DEFLATE_RATIO_MAX > r->file.size) png_error(r->png, "truncated PNG");
    const int passes = set_transformations(r);
    if (!r->raw || (r->grey && r->channels == 1)) {
        read_rows(r, passes);
        png_read_end(r->png, NULL);
    }
    return true;
}

static bool read_png(Reading *r, const FfpEncoded *file, bool raw, FfpError *err) {
    *r = (Reading){.file = *file, .raw = raw};
    if (!ffp_png_size(file, &r->width, &r->height, err)) return false;
    const bool ok = read_pixels(r);
    png_destroy_read_struct(&r->png, &r->info, NULL);
    ffp_free(r->pixels);
    if (!ok) ffp_free(r->values);
    if (r->no_memory) return ffp_fail(err, FFP_ERROR_MEMORY, file->path, "out of memory");
    if (!ok) {
        ffp_fail(err, FFP_ERROR_FILE, file->path, "%s%s",
                 r->truncated ? "truncated PNG" : "broken PNG: ", r->truncated ? "" : r->message);
    }
    return ok;
}

bool ffp_png_decode(const FfpEncoded *file, FfpDecoded *out, FfpError *err) {
    Reading r;
    if (!read_png(&r, file, false, err)) return false;
    out->image = (FfpImage){r.width, r.height, 4, r.values};
    out->has_alpha = r.has_alpha;
    return true;
}

bool ffp_png_decode_raw(const FfpEncoded *file, FfpDecoded *out, FfpError *err) {
    Reading r;
    if (!read_png(&r, file, true, err)) return false;
    if (!r.values) return ffp_fail(err, FFP_ERROR_FILE, file->path, "is not a grey image");
    out->image = (FfpImage){r.width, r.height, 1, r.values};
    return true;
}

// --- Writing: into memory, from where the caller takes it to a file. ---

// The source of a file: an image, or rows that are made one after the other.
typedef struct Rows {
    int width, height, channels;
    const FfpImage *image; // NULL: rows are made
    void (*make)(void *context, int y, real *row);
    void *context;
    real *made; // room for one of them
} Rows;

static const real *row_at(const Rows *rows, int y) {
    const size_t count = (size_t)rows->width * (size_t)rows->channels;
    if (rows->image) return rows->image->data + (size_t)y * count;
    rows->make(rows->context, y, rows->made);
    return rows->made;
}

typedef struct Writing {
    png_structp png;
    png_infop info;
    FILE *stream; // NULL: the bytes are kept
    unsigned char *bytes, *row;
    size_t size, capacity;
    bool no_memory;
    char message[160];
} Writing;

static void keep_bytes(Writing *w, png_bytep from, size_t count) {
    if (count > w->capacity - w->size) {
        const size_t capacity = 2 * w->capacity + count + 4096;
        unsigned char *larger = ffp_try_grow(w->bytes, capacity, 1);
        if (!larger) {
            w->no_memory = true;
            png_error(w->png, "out of memory");
        }
        w->bytes = larger;
        w->capacity = capacity;
    }
    memcpy(w->bytes + w->size, from, count);
    w->size += count;
}

static void take_bytes(png_structp png, png_bytep from, size_t count) {
    Writing *w = png_get_io_ptr(png);
    if (!w->stream)
        keep_bytes(w, from, count);
    else if (fwrite(from, 1, count, w->stream) != count)
        png_error(png, "disk full?");
}

static void nothing_to_flush(png_structp png) {
    (void)png;
}

// A value clamped to [0, 1] and rounded to an integer up to `top`. NaN becomes 0.
static inline int quantise(real value, double top) {
    const double bound = value > 0 ? (value < 1 ? (double)value : 1) : 0;
    return (int)(bound * top + 0.5);
}

// One row as integers of 8 or 16 bits, big endian.
static void quantise_row(const real *from, size_t count, int depth, unsigned char *to) {
    if (depth == 8) {
        for (size_t i = 0; i < count; i++) to[i] = (unsigned char)quantise(from[i], 255);
        return;
    }
    for (size_t i = 0; i < count; i++) {
        const int q = quantise(from[i], 65535);
        to[2 * i] = (unsigned char)(q >> 8);
        to[2 * i + 1] = (unsigned char)(q & 255);
    }
}

// True if most pixels equal their left neighbour, as in a pattern of even fields.
static bool has_even_fields(const Rows *rows) {
    const size_t n = (size_t)rows->channels, row = (size_t)rows->width * n;
    size_t same = 0;
    for (int y = 0; y < rows->height; y++) {
        const real *line = row_at(rows, y);
        for (size_t i = n; i < row; i++) same += line[i] == line[i - n];
    }
    return 4 * same > 3 * row * (size_t)rows->height;
}

// Even fields repeat whole stretches of rows, which deflate finds unfiltered. The rest of a picture repeats
// itself by chance alone: of the differences between neighbours no more than runs and frequencies are worth
// the search. Both take a quarter to a half of the time of libpng's own choices, for at most a quarter more
// bytes.
static void set_compression(png_structp png, bool even) {
    png_set_filter(png, PNG_FILTER_TYPE_BASE, even ? PNG_FILTER_NONE : PNG_FILTER_SUB);
    png_set_compression_strategy(png, even ? Z_DEFAULT_STRATEGY : Z_RLE);
    png_set_compression_level(png, 3);
}

static bool write_pixels(Writing *w, const Rows *rows, int depth, bool even) {
    static const int types[5] = {0, PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_GRAY_ALPHA, PNG_COLOR_TYPE_RGB,
                                 PNG_COLOR_TYPE_RGB_ALPHA};
    w->png = png_create_write_struct_2(PNG_LIBPNG_VER_STRING, w->message, on_error, on_warning, &w->no_memory,
                                       take_memory, give_memory);
    w->info = w->png ? png_create_info_struct(w->png) : NULL;
    if (!w->info) return false;
    if (setjmp(png_jmpbuf(w->png))) return false;
    png_set_write_fn(w->png, w, take_bytes, nothing_to_flush);
    png_set_IHDR(w->png, w->info, (png_uint_32)rows->width, (png_uint_32)rows->height, depth,
                 types[rows->channels], PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                 PNG_FILTER_TYPE_DEFAULT);
    set_compression(w->png, even);
    png_write_info(w->png, w->info);
    const size_t count = (size_t)rows->width * (size_t)rows->channels;
    for (int y = 0; y < rows->height; y++) {
        quantise_row(row_at(rows, y), count, depth, w->row);
        png_write_row(w->png, w->row);
    }
    png_write_end(w->png, NULL);
    return true;
}

static bool encode(Writing *w, Rows *rows, int depth, const char *where, FfpError *err) {
    if ((rows->image && !rows->image->data) || rows->channels < 1 || rows->channels > 4)
        return ffp_fail(err, FFP_ERROR_ARGUMENT, where, "cannot write an image of %d channels as PNG",
                        rows->channels);
    const size_t count = (size_t)rows->width * (size_t)rows->channels;
    snprintf(w->message, sizeof w->message, "out of memory");
    w->row = ffp_alloc(count, 2);
    if (!rows->image) rows->made = ffp_alloc(count, sizeof *rows->made);
    const bool ok = write_pixels(w, rows, depth, has_even_fields(rows));
    png_destroy_write_struct(&w->png, &w->info);
    ffp_free(w->row);
    ffp_free(rows->made);
    return ok || ffp_fail(err, w->no_memory ? FFP_ERROR_MEMORY : FFP_ERROR_IO, where, "cannot write PNG: %s",
                          w->message);
}

static Rows rows_of(const FfpImage *image) {
    return (Rows){
        .width = image->width, .height = image->height, .channels = image->channels, .image = image};
}

static bool write_png(Rows rows, int depth, const char *path, FfpError *err) {
    FfpOutput out;
    if (!ffp_output_open(&out, path, err)) return false;
    Writing w = {.stream = out.stream};
    if (encode(&w, &rows, depth, path, err)) return ffp_output_commit(&out, err);
    ffp_output_abort(&out);
    return false;
}

bool ffp_image_encode_png(const FfpImage *image, unsigned char **bytes, size_t *size, FfpError *err) {
    Rows rows = rows_of(image);
    Writing w = {.size = 0};
    const bool ok = encode(&w, &rows, 8, NULL, err);
    if (!ok) ffp_free(w.bytes);
    *bytes = ok ? w.bytes : NULL;
    *size = ok ? w.size : 0;
    return ok;
}

bool ffp_image_write_png(const FfpImage *image, const char *path, FfpError *err) {
    return write_png(rows_of(image), 8, path, err);
}

bool ffp_image_write_png16(const FfpImage *image, const char *path, FfpError *err) {
    return write_png(rows_of(image), 16, path, err);
}

bool ffp_image_write_png_rows(const FfpRows *made, int depth, const char *path, FfpError *err) {
    const Rows rows = {.width = made->width,
                       .height = made->height,
                       .channels = made->channels,
                       .make = made->make,
                       .context = made->context};
    return write_png(rows, depth, path, err);
}

static void encode_row(void *context, int y, real *row) {
    const FfpImage *linear = context;
    const size_t count = (size_t)linear->width * (size_t)linear->channels;
    memcpy(row, linear->data + (size_t)y * count, count * sizeof *row);
    FfpImage line = {linear->width, 1, linear->channels, row};
    ffp_image_to_srgb(&line);
}

bool ffp_image_write_png_encoded(const FfpImage *linear, const char *path, FfpError *err) {
    FfpImage image = *linear;
    const FfpRows rows = {image.width, image.height, image.channels, encode_row, &image};
    return ffp_image_write_png_rows(&rows, 8, path, err);
}
