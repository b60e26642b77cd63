// The data that cameras write beside a picture (EXIF 2.3, JEITA CP-3451C): directories of a TIFF.
#include <string.h>
#include "core/image/codec.h"

enum { TAG_ORIENTATION = 0x0112, TAG_OF_PHOTOGRAPH = 0x8769, TAG_FOCAL_35MM = 0xa405 };
enum { TYPE_SHORT = 3, TYPE_LONG = 4 };

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

// The value of a tag in the directory at `directory`; 0: there is none, or it is of another type.
static size_t value_of(const Exif *exif, size_t directory, size_t tag, size_t type) {
    const size_t entries = number_at(exif, directory, 2);
    for (size_t i = 0; i < entries; i++) {
        const size_t entry = directory + 2 + 12 * i;
        if (number_at(exif, entry, 2) != tag) continue;
        return number_at(exif, entry + 2, 2) == type ? number_at(exif, entry + 8, type == TYPE_SHORT ? 2 : 4)
                                                     : 0;
    }
    return 0;
}

static bool open_exif(Exif *exif, const unsigned char *bytes, size_t size) {
    *exif = (Exif){bytes, size, true};
    if (size < 8 || (memcmp(bytes, "II*\0", 4) != 0 && memcmp(bytes, "MM\0*", 4) != 0)) return false;
    exif->little_endian = bytes[0] == 'I';
    return true;
}

int ffp_exif_orientation(const unsigned char *bytes, size_t size) {
    Exif exif;
    if (!open_exif(&exif, bytes, size)) return 1;
    const size_t value = value_of(&exif, number_at(&exif, 4, 4), TAG_ORIENTATION, TYPE_SHORT);
    return value >= 1 && value <= 8 ? (int)value : 1;
}

int ffp_exif_focal_35mm(const unsigned char *bytes, size_t size) {
    Exif exif;
    if (!open_exif(&exif, bytes, size)) return 0;
    const size_t directory = value_of(&exif, number_at(&exif, 4, 4), TAG_OF_PHOTOGRAPH, TYPE_LONG);
    return directory > 0 ? (int)value_of(&exif, directory, TAG_FOCAL_35MM, TYPE_SHORT) : 0;
}
