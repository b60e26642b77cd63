// The data that cameras write beside a picture (EXIF 2.3, JEITA CP-3451C): directories of a TIFF.
#include <string.h>
#include "core/image/codec.h"

enum {
    TAG_RULE = 0x0001, // in the directory of interoperability
    TAG_MODEL = 0x0110,
    TAG_ORIENTATION = 0x0112,
    TAG_OF_PHOTOGRAPH = 0x8769,
    TAG_FOCAL = 0x920a,
    TAG_COLOURS = 0xa001,
    TAG_OF_RULES = 0xa005,
    TAG_ZOOM = 0xa404,
    TAG_FOCAL_35MM = 0xa405,
    TAG_SERIAL = 0xa431,
    TAG_LENS = 0xa434
};
enum { TYPE_TEXT = 2, TYPE_SHORT = 3, TYPE_LONG = 4, TYPE_RATIO = 5, COLOURS_ADOBE = 2 };

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

// Where the value of a tag is, in the directory at `directory`; 0: there is none, or it is of another type.
static size_t find_value(const Exif *exif, size_t directory, size_t tag, size_t type) {
    const size_t entries = number_at(exif, directory, 2);
    for (size_t i = 0; i < entries; i++) {
        const size_t entry = directory + 2 + 12 * i;
        if (number_at(exif, entry, 2) != tag) continue;
        return number_at(exif, entry + 2, 2) == type ? entry + 8 : 0;
    }
    return 0;
}

static size_t value_of(const Exif *exif, size_t directory, size_t tag, size_t type) {
    const size_t at = find_value(exif, directory, tag, type);
    return at ? number_at(exif, at, type == TYPE_SHORT ? 2 : 4) : 0;
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

static void take_text(const Exif *exif, size_t directory, size_t tag, char out[FFP_TAKEN_TEXT]) {
    const size_t value = find_value(exif, directory, tag, TYPE_TEXT);
    size_t length = value ? number_at(exif, value - 4, 4) : 0;
    const size_t at = length > 4 ? number_at(exif, value, 4) : value;
    if (at > exif->size || length > exif->size - at) return;
    if (length >= FFP_TAKEN_TEXT) length = FFP_TAKEN_TEXT - 1;
    memcpy(out, exif->bytes + at, length);
    for (char *c = out; *c; c++) // findings are UTF-8, and a terminal shows them
        if (*c < ' ' || *c > '~') *c = '?';
    for (length = strlen(out); length > 0 && out[length - 1] == ' ';) out[--length] = 0;
}

// 0: there is none, or nothing by nothing.
static double ratio_of(const Exif *exif, size_t directory, size_t tag) {
    const size_t at = value_of(exif, directory, tag, TYPE_RATIO);
    const double below = at ? (double)number_at(exif, at + 4, 4) : 0;
    return below > 0 ? (double)number_at(exif, at, 4) / below : 0;
}

FfpTakenBy ffp_exif_taken_by(const unsigned char *bytes, size_t size) {
    FfpTakenBy by = {.focal_35mm = 0};
    Exif exif;
    if (!open_exif(&exif, bytes, size)) return by;
    const size_t first = number_at(&exif, 4, 4),
                 directory = value_of(&exif, first, TAG_OF_PHOTOGRAPH, TYPE_LONG);
    take_text(&exif, first, TAG_MODEL, by.model);
    if (directory == 0) return by;
    take_text(&exif, directory, TAG_SERIAL, by.serial);
    take_text(&exif, directory, TAG_LENS, by.lens);
    by.focal_35mm = (double)value_of(&exif, directory, TAG_FOCAL_35MM, TYPE_SHORT);
    by.focal = ratio_of(&exif, directory, TAG_FOCAL);
    by.zoom = ratio_of(&exif, directory, TAG_ZOOM);
    if (find_value(&exif, directory, TAG_ZOOM, TYPE_RATIO) && !(by.zoom > 0)) by.zoom = 1; // it was not used
    return by;
}

bool ffp_exif_is_adobe_rgb(const unsigned char *bytes, size_t size) {
    Exif exif;
    if (!open_exif(&exif, bytes, size)) return false;
    const size_t directory = value_of(&exif, number_at(&exif, 4, 4), TAG_OF_PHOTOGRAPH, TYPE_LONG);
    if (directory == 0) return false;
    if (value_of(&exif, directory, TAG_COLOURS, TYPE_SHORT) == COLOURS_ADOBE) return true;
    const size_t rules = value_of(&exif, directory, TAG_OF_RULES, TYPE_LONG),
                 rule = rules ? find_value(&exif, rules, TAG_RULE, TYPE_TEXT) : 0;
    return rule && size >= rule + 4 && memcmp(bytes + rule, "R03", 3) == 0;
}
