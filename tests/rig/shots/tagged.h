// Photographs with what a camera writes of itself into them (EXIF).
#ifndef FFP_TESTS_TAGGED_H
#define FFP_TESTS_TAGGED_H

#include <math.h>
#include "core/image/image.h"
#include "core/image/picture_files.h"

enum { TAGGED_SIZE = 512, TAGGED_LEAST = 6 + 8 + 42 + 66 };

typedef struct Tagging {
    unsigned char *bytes; // of a TIFF, most significant first
    size_t entry, free;   // where the next entry and its value go
} Tagging;

static inline void put_big(unsigned char *at, size_t value, int bytes) {
    for (int i = bytes - 1; i >= 0; i--, value >>= 8) at[i] = (unsigned char)value;
}

// type: 2 text, 3 short, 4 long, 5 ratio. A value that is not told is left out of the data, not of their
// size.
static inline void put_tag(Tagging *t, int tag, int type, const char *text, double number) {
    unsigned char *entry = t->bytes + t->entry;
    const size_t length = type == 2 ? strlen(text) + 1 : 1;
    t->entry += 12;
    if (type == 2 ? text[0] == 0 : number < 0) return;
    put_big(entry, (size_t)tag, 2), put_big(entry + 2, (size_t)type, 2), put_big(entry + 4, length, 4);
    if (type == 3) put_big(entry + 8, (size_t)number, 2);
    if (type == 4) put_big(entry + 8, (size_t)number, 4);
    if (type == 2 && length <= 4) memcpy(entry + 8, text, length);
    if (type != 5 && !(type == 2 && length > 4)) return;
    put_big(entry + 8, t->free, 4);
    if (type == 2) memcpy(t->bytes + t->free, text, length);
    if (type == 5) put_big(t->bytes + t->free, (size_t)lround(100 * number), 4);
    if (type == 5) put_big(t->bytes + t->free + 4, 100, 4);
    t->free += type == 2 ? length : 8;
}

// "Exif", and the data; the size of all. A zoom of 0 is written, as cameras do that did not use it.
static inline size_t make_tags(unsigned char exif[TAGGED_SIZE], const FfpTakenBy *by, int orientation) {
    Tagging t = {exif + 6, 8, TAGGED_LEAST - 6};
    memset(exif, 0, TAGGED_SIZE);
    memcpy(exif, "Exif\0\0MM\0*\0\0\0\10\0\3", 16);
    t.entry = 10;
    put_tag(&t, 0x0110, 2, by->model, 0);
    put_tag(&t, 0x0112, 3, NULL, orientation);
    put_tag(&t, 0x8769, 4, NULL, 50);
    put_big(t.bytes + 50, 5, 2);
    t.entry = 52;
    put_tag(&t, 0x920a, 5, NULL, by->focal > 0 ? by->focal : -1);
    put_tag(&t, 0xa404, 5, NULL, by->zoom);
    put_tag(&t, 0xa405, 3, NULL, by->focal_35mm > 0 ? by->focal_35mm : -1);
    put_tag(&t, 0xa431, 2, by->serial, 0);
    put_tag(&t, 0xa434, 2, by->lens, 0);
    return 6 + t.free;
}

// A JPEG of RGB with these data.
static inline void write_tagged(const char *path, const unsigned char *rgb, int width, int height,
                                const FfpTakenBy *by, int orientation) {
    unsigned char exif[TAGGED_SIZE];
    const JpegKind kind = {
        .given = JCS_RGB, .stored = JCS_YCbCr, .exif = exif, .exif_size = make_tags(exif, by, orientation)};
    write_jpeg_kind(path, rgb, width, height, &kind);
}

#endif
