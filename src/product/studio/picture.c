// Checks of a photograph's bytes before they are kept: a browser, a camera's program or anybody who has the
// address may have sent them.
#include <string.h>
#include "rules.h"

enum { SIDE_MOST = 65500 };

static unsigned at2(const unsigned char *b) {
    return (unsigned)b[0] << 8 | b[1];
}

static unsigned long at4(const unsigned char *b) {
    return (unsigned long)at2(b) << 16 | at2(b + 2);
}

// PNG 1.2, 3 to 5: a signature, chunks of length, name, data and sum, IHDR first and IEND last.
static bool png_size(const unsigned char *bytes, size_t size, unsigned long *width, unsigned long *height) {
    if (size < 57 || memcmp(bytes + 12, "IHDR", 4) != 0 || at4(bytes + 8) != 13) return false;
    *width = at4(bytes + 16), *height = at4(bytes + 20);
    for (size_t at = 8; size - at >= 12;) {
        const unsigned long length = at4(bytes + at);
        if (length > size - at - 12) return false;
        if (memcmp(bytes + at + 4, "IEND", 4) == 0) return true;
        at += 12 + length;
    }
    return false;
}

// JPEG (ITU-T T.81, B.1): segments of marker and length up to the frame header; the end of the image last.
static bool jpeg_size(const unsigned char *bytes, size_t size, unsigned long *width, unsigned long *height) {
    size_t end = size, at = 2;
    while (end > 2 && bytes[end - 1] == 0) end--; // cameras pad
    if (end < 4 || at2(bytes + end - 2) != 0xffd9) return false;
    while (size - at >= 10) {
        if (bytes[at] != 0xff) return false;
        const unsigned kind = bytes[at + 1], length = at2(bytes + at + 2);
        if (kind == 0xff) {
            at++;
            continue;
        }
        if (kind >= 0xc0 && kind <= 0xcf && kind != 0xc4 && kind != 0xc8 && kind != 0xcc) {
            *height = at2(bytes + at + 5), *width = at2(bytes + at + 7);
            return true;
        }
        if (length < 2 || length > size - at - 2) return false;
        at += 2 + length;
    }
    return false;
}

bool ffp_studio_picture(const unsigned char *bytes, size_t size, int *width, int *height,
                        const char **ending) {
    static const unsigned char signature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    unsigned long w = 0, h = 0;
    bool ok = false;
    if (size > 8 && memcmp(bytes, signature, 8) == 0)
        ok = png_size(bytes, size, &w, &h), *ending = "png";
    else if (size > 4 && bytes[0] == 0xff && bytes[1] == 0xd8)
        ok = jpeg_size(bytes, size, &w, &h), *ending = "jpg";
    if (!ok || w == 0 || h == 0 || w > SIDE_MOST || h > SIDE_MOST) return false;
    *width = (int)w, *height = (int)h;
    return true;
}
