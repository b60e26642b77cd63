// The orientation tag of cameras: which side of the stored picture was up.
#include <string.h>
#include "core/image/codec.h"

#define TAG_ORIENTATION 0x0112
#define TYPE_SHORT 3

typedef struct Exif {
    const unsigned char *bytes;
    size_t size;
    bool little_endian;
} Exif;

// The number of 2 or 4 bytes at `at`, 0 beyond the end.
static size_t number_at(const Exif *exif, size_t at, size_t bytes) {
    size_t value = 0;
    if (at > exif->size || exif->size - at < bytes) return 0;
    for (size_t i = 0; i < bytes; i++) {
        const size_t place = exif->little_endian ? bytes - 1 - i : i;
        value = value << 8 | exif->bytes[at + place];
    }
    return value;
}

int ffp_exif_orientation(const unsigned char *bytes, size_t size) {
    Exif exif = {bytes, size, true};
    if (size < 8 || (memcmp(bytes, "II*\0", 4) != 0 && memcmp(bytes, "MM\0*", 4) != 0)) return 1;
    exif.little_endian = bytes[0] == 'I';
    const size_t directory = number_at(&exif, 4, 4), entries = number_at(&exif, directory, 2);
    for (size_t i = 0; i < entries; i++) {
        const size_t entry = directory + 2 + 12 * i;
        if (number_at(&exif, entry, 2) != TAG_ORIENTATION) continue;
        const size_t value = number_at(&exif, entry + 8, 2);
        const bool sound = number_at(&exif, entry + 2, 2) == TYPE_SHORT && value >= 1 && value <= 8;
        return sound ? (int)value : 1;
    }
    return 1;
}

// From 5 on rows and columns change places.
void ffp_orient_size(int *width, int *height, int orientation) {
    const int old = *width;
    if (orientation < 5) return;
    *width = *height;
    *height = old;
}

void ffp_orient(FfpImage *image, int orientation) {
    if (orientation < 2 || orientation > 8) return;
    int width = image->width, height = image->height;
    const bool across = orientation >= 5;
    // whether the stored picture's columns and rows are counted from the other end
    const bool right = orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8;
    const bool below = orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;
    ffp_orient_size(&width, &height, orientation);
    FfpImage out = ffp_image_new(width, height, image->channels);
    const size_t bytes = (size_t)image->channels * sizeof(real);
    for (int y = 0; y < height; y++) {
        for (int x = 0; x < width; x++) {
            const int column = across ? y : x, row = across ? x : y;
            const size_t from = (size_t)(below ? image->height - 1 - row : row) * (size_t)image->width +
                                (size_t)(right ? image->width - 1 - column : column);
            const size_t to = (size_t)y * (size_t)width + (size_t)x;
            memcpy(out.data + to * (size_t)image->channels, image->data + from * (size_t)image->channels,
                   bytes);
        }
    }
    ffp_image_free(image);
    *image = out;
}

const char *ffp_orientation_words(int orientation) {
    static const char *const words[9] = {"",
                                         "",
                                         "mirrored",
                                         "turned by 180 degrees",
                                         "turned by 180 degrees and mirrored",
                                         "turned clockwise by 90 degrees and mirrored",
                                         "turned clockwise by 90 degrees",
                                         "turned anticlockwise by 90 degrees and mirrored",
                                         "turned anticlockwise by 90 degrees"};
    return words[orientation >= 0 && orientation <= 8 ? orientation : 0];
}
