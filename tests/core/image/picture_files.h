// Picture files as other programs write them.
#ifndef FFP_TESTS_PICTURE_FILES_H
#define FFP_TESTS_PICTURE_FILES_H

#include <openexr.h>
#include <png.h>
#include <stdio.h>
#include <tiffio.h>
#include <jpeglib.h>
#include "scratch.h"

// --- PNG: grey, of one value. ---

static inline void write_flat_png(const char *path, int width, int height, int depth, int colour, int value) {
    FILE *stream = fopen(path, "wb");
    assert_non_null(stream);
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    png_infop info = png_create_info_struct(png);
    png_init_io(png, stream);
    png_set_compression_level(png, 9);
    png_set_IHDR(png, info, (png_uint_32)width, (png_uint_32)height, depth, colour, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    if (colour == PNG_COLOR_TYPE_PALETTE) {
        const png_color palette[2] = {{255, 0, 0}, {0, 0, 255}};
        png_set_PLTE(png, info, palette, 2);
    }
    png_write_info(png, info);
    const size_t bytes = png_get_rowbytes(png, info);
    unsigned char *row = malloc(bytes);
    memset(row, value, bytes);
    for (int y = 0; y < height; y++) png_write_row(png, row);
    png_write_end(png, NULL);
    png_destroy_write_struct(&png, &info);
    free(row);
    fclose(stream);
}

// --- JPEG. ---

typedef struct JpegKind {
    J_COLOR_SPACE given, stored; // of the pixels, and in the file
    bool no_adobe_marker;
    const unsigned char *exif; // NULL: none
    size_t exif_size;
} JpegKind;

// pixels: [height, width, 3 or 4]
static inline void write_jpeg_kind(const char *path, const unsigned char *pixels, int width, int height,
                                   const JpegKind *kind) {
    struct jpeg_compress_struct jpeg = {0};
    struct jpeg_error_mgr errors;
    FILE *stream = fopen(path, "wb");
    assert_non_null(stream);
    jpeg.err = jpeg_std_error(&errors);
    jpeg_create_compress(&jpeg);
    jpeg_stdio_dest(&jpeg, stream);
    jpeg.image_width = (JDIMENSION)width, jpeg.image_height = (JDIMENSION)height;
    jpeg.in_color_space = kind->given;
    jpeg.input_components = kind->given == JCS_CMYK ? 4 : 3;
    jpeg_set_defaults(&jpeg);
    jpeg_set_colorspace(&jpeg, kind->stored);
    jpeg_set_quality(&jpeg, 98, TRUE);
    if (kind->no_adobe_marker) jpeg.write_Adobe_marker = FALSE;
    jpeg_start_compress(&jpeg, TRUE);
    if (kind->exif) jpeg_write_marker(&jpeg, JPEG_APP0 + 1, kind->exif, (unsigned)kind->exif_size);
    for (int y = 0; y < height; y++) {
        JSAMPROW row = (JSAMPROW)(pixels + (size_t)y * (size_t)width * (size_t)jpeg.input_components);
        jpeg_write_scanlines(&jpeg, &row, 1);
    }
    jpeg_finish_compress(&jpeg);
    jpeg_destroy_compress(&jpeg);
    fclose(stream);
}

// --- TIFF. ---

typedef struct TiffKind {
    const char *mode; // "w", "wb": big endian, "w8": BigTIFF
    int bits, channels, photometric, compression;
    bool floats, tiled, separate;
    int extra, orientation; // extra: EXTRASAMPLE_* of the last channel, -1: not said
} TiffKind;

// Sample c of the pixel (x, y): whole numbers that fit 8 bits.
static inline int tiff_sample(int x, int y, int c) {
    return (7 * x + 13 * y + 61 * c + 5) % 251;
}

static inline void put_sample(unsigned char *row, size_t at, const TiffKind *kind, int value) {
    if (kind->bits == 1) {
        if (value & 1) row[at / 8] |= (unsigned char)(0x80 >> at % 8);
    } else if (kind->bits == 8) {
        row[at] = (unsigned char)value;
    } else if (kind->bits == 16) {
        const uint16_t word = (uint16_t)(value * 257);
        memcpy(row + 2 * at, &word, 2);
    } else if (kind->bits == 32) {
        const float single = (float)value / 128;
        memcpy(row + 4 * at, &single, 4);
    }
}

static inline void set_tiff_fields(TIFF *tiff, int width, int height, const TiffKind *kind) {
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, width);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, height);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, kind->bits);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, kind->channels);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, kind->photometric);
    TIFFSetField(tiff, TIFFTAG_COMPRESSION, kind->compression);
    TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, kind->floats ? SAMPLEFORMAT_IEEEFP : SAMPLEFORMAT_UINT);
    TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, kind->separate ? PLANARCONFIG_SEPARATE : PLANARCONFIG_CONTIG);
    if (kind->orientation) TIFFSetField(tiff, TIFFTAG_ORIENTATION, kind->orientation);
    const uint16_t extra = (uint16_t)kind->extra;
    if (kind->extra >= 0) TIFFSetField(tiff, TIFFTAG_EXTRASAMPLES, 1, &extra);
    if (kind->tiled) {
        TIFFSetField(tiff, TIFFTAG_TILEWIDTH, 16);
        TIFFSetField(tiff, TIFFTAG_TILELENGTH, 32);
    } else {
        TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 5);
    }
}

static inline void write_tiff_kind(const char *path, int width, int height, const TiffKind *kind) {
    TIFF *tiff = TIFFOpen(path, kind->mode ? kind->mode : "w");
    assert_non_null(tiff);
    set_tiff_fields(tiff, width, height, kind);
    const int planes = kind->separate ? kind->channels : 1, here = kind->separate ? 1 : kind->channels;
    const int block_width = kind->tiled ? 16 : width, block_height = kind->tiled ? 32 : 5;
    const size_t row = (size_t)(block_width * here * kind->bits + 7) / 8;
    unsigned char *block = malloc(row * (size_t)block_height);
    for (int p = 0; p < planes; p++) {
        for (int top = 0; top < height; top += block_height) {
            for (int left = 0; left < width; left += block_width) {
                memset(block, 0, row * (size_t)block_height);
                for (int y = top; y < height && y < top + block_height; y++)
                    for (int x = left; x < width && x < left + block_width; x++)
                        for (int c = 0; c < here; c++)
                            put_sample(block + (size_t)(y - top) * row, (size_t)((x - left) * here + c), kind,
                                       tiff_sample(x, y, p + c));
                const int rows = kind->tiled || height - top > block_height ? block_height : height - top;
                const tmsize_t size = (tmsize_t)((size_t)rows * row);
                if (kind->tiled)
                    assert_true(TIFFWriteEncodedTile(
                                    tiff,
                                    TIFFComputeTile(tiff, (uint32_t)left, (uint32_t)top, 0, (uint16_t)p),
                                    block, size) >= 0);
                else
                    assert_true(TIFFWriteEncodedStrip(tiff,
                                                      TIFFComputeStrip(tiff, (uint32_t)top, (uint16_t)p),
                                                      block, size) >= 0);
            }
        }
    }
    free(block);
    TIFFClose(tiff);
}

// --- EXR. ---

#define EXR_TEST_CHANNELS 16

typedef struct ExrPart {
    const char *channels[EXR_TEST_CHANNELS]; // ends with NULL
    int width, height, tile;                 // tile: side of the tiles, 0: lines
    bool levels;                             // mipmap
    exr_compression_t compression;
} ExrPart;

// The value of channel c of part p at (x, y).
static inline float exr_sample(int p, int c, int x, int y) {
    return (float)(1000 * p + 100 * c) + (float)(x + 3 * y) / 4;
}

static inline void put_exr_chunk(exr_context_t exr, int p, const ExrPart *part, const exr_chunk_info_t *chunk,
                                 float *const *planes, size_t at) {
    exr_encode_pipeline_t encoder = EXR_ENCODE_PIPELINE_INITIALIZER;
    assert_int_equal(exr_encoding_initialize(exr, p, chunk, &encoder), EXR_ERR_SUCCESS);
    for (int i = 0; i < encoder.channel_count; i++) {
        exr_coding_channel_info_t *channel = &encoder.channels[i];
        int c = 0;
        while (strcmp(part->channels[c], channel->channel_name) != 0) c++;
        channel->encode_from_ptr = (const uint8_t *)(planes[c] + at);
        channel->user_data_type = EXR_PIXEL_FLOAT;
        channel->user_bytes_per_element = channel->user_pixel_stride = sizeof(float);
        channel->user_line_stride = part->width * (int)sizeof(float);
    }
    assert_int_equal(exr_encoding_choose_default_routines(exr, p, &encoder), EXR_ERR_SUCCESS);
    assert_int_equal(exr_encoding_run(exr, p, &encoder), EXR_ERR_SUCCESS);
    exr_encoding_destroy(exr, &encoder);
}

static inline void put_exr_pixels(exr_context_t exr, int p, const ExrPart *part) {
    float *planes[EXR_TEST_CHANNELS] = {NULL};
    exr_chunk_info_t chunk;
    for (int c = 0; part->channels[c]; c++) {
        planes[c] = malloc((size_t)(part->width * part->height) * sizeof(float));
        for (int i = 0; i < part->width * part->height; i++)
            planes[c][i] = exr_sample(p, c, i % part->width, i / part->width);
    }
    int lines = 0;
    if (!part->tile) assert_int_equal(exr_get_scanlines_per_chunk(exr, p, &lines), EXR_ERR_SUCCESS);
    for (int y = 0; !part->tile && y < part->height; y += lines) {
        assert_int_equal(exr_write_scanline_chunk_info(exr, p, y, &chunk), EXR_ERR_SUCCESS);
        put_exr_chunk(exr, p, part, &chunk, planes, (size_t)(y * part->width));
    }
    int levels = part->tile ? 1 : 0;
    if (part->levels) assert_int_equal(exr_get_tile_levels(exr, p, &levels, NULL), EXR_ERR_SUCCESS);
    for (int l = 0; l < levels; l++) {
        const int width = part->width >> l > 0 ? part->width >> l : 1;
        const int height = part->height >> l > 0 ? part->height >> l : 1;
        for (int y = 0; y < height; y += part->tile)
            for (int x = 0; x < width; x += part->tile) {
                assert_int_equal(
                    exr_write_tile_chunk_info(exr, p, x / part->tile, y / part->tile, l, l, &chunk),
                    EXR_ERR_SUCCESS);
                put_exr_chunk(exr, p, part, &chunk, planes, (size_t)(y * part->width + x));
            }
    }
    for (int c = 0; part->channels[c]; c++) free(planes[c]);
}

static inline void write_exr_parts(const char *path, const ExrPart *parts, int n) {
    exr_context_t exr = NULL;
    assert_int_equal(exr_start_write(&exr, path, EXR_WRITE_FILE_DIRECTLY, NULL), EXR_ERR_SUCCESS);
    for (int p = 0; p < n; p++) {
        char name[16];
        int index;
        const ExrPart *part = &parts[p];
        snprintf(name, sizeof name, "part%d", p);
        assert_int_equal(
            exr_add_part(exr, name, part->tile ? EXR_STORAGE_TILED : EXR_STORAGE_SCANLINE, &index),
            EXR_ERR_SUCCESS);
        assert_int_equal(
            exr_initialize_required_attr_simple(exr, p, part->width, part->height, part->compression),
            EXR_ERR_SUCCESS);
        for (int c = 0; part->channels[c]; c++)
            assert_int_equal(exr_add_channel(exr, p, part->channels[c], EXR_PIXEL_FLOAT,
                                             EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1),
                             EXR_ERR_SUCCESS);
        if (part->tile)
            assert_int_equal(
                exr_set_tile_descriptor(exr, p, (uint32_t)part->tile, (uint32_t)part->tile,
                                        part->levels ? EXR_TILE_MIPMAP_LEVELS : EXR_TILE_ONE_LEVEL,
                                        EXR_TILE_ROUND_DOWN),
                EXR_ERR_SUCCESS);
    }
    assert_int_equal(exr_write_header(exr), EXR_ERR_SUCCESS);
    for (int p = 0; p < n; p++) put_exr_pixels(exr, p, &parts[p]);
    assert_int_equal(exr_finish(&exr), EXR_ERR_SUCCESS);
}

#endif
