// Where files have their profiles.
#include <string.h>
#include <zlib.h>
#include "core/base/alloc.h"
#include "core/image/profile.h"

enum { PNG_BEGIN = 8, CHUNK = 12, NAME_MAX_BYTES = 80, PARTS_HEAD = 14, RATIO = 1032 };

static uint32_t big32(const unsigned char *at) {
    return (uint32_t)at[0] << 24 | (uint32_t)at[1] << 16 | (uint32_t)at[2] << 8 | at[3];
}

FfpColourProfile ffp_profile_of_icc(const void *bytes, size_t size) {
    FfpColourProfile profile = {0};
    if (size == 0 || size > FFP_PROFILE_MAX) return profile;
    profile.kind = FFP_PROFILE_ICC;
    profile.icc = ffp_alloc(size, 1);
    profile.size = size;
    memcpy(profile.icc, bytes, size);
    return profile;
}

// iCCP: a name, 0, the method 0, a stream of zlib.
static FfpColourProfile unpack(const unsigned char *data, size_t length) {
    FfpColourProfile none = {0};
    const unsigned char *end = memchr(data, 0, length < NAME_MAX_BYTES ? length : NAME_MAX_BYTES);
    const size_t head = end ? (size_t)(end - data) + 2 : length;
    if (head >= length || data[head - 1] != 0) return none;
    const size_t packed = length - head,
                 most = packed < FFP_PROFILE_MAX / RATIO ? packed * RATIO : FFP_PROFILE_MAX;
    unsigned char *bytes = ffp_take(most, 1);
    uLongf size = (uLongf)most;
    if (uncompress(bytes, &size, data + head, (uLong)packed) != Z_OK) size = 0;
    FfpColourProfile profile = ffp_profile_of_icc(bytes, size);
    ffp_free(bytes);
    return profile;
}

// Coding-independent code points (ITU-T H.273): primaries and transfer.
static FfpColourProfile of_code_points(const unsigned char *data) {
    static const double bt709[6] = {0.64, 0.33, 0.30, 0.60, 0.15, 0.06},
                        bt2020[6] = {0.708, 0.292, 0.170, 0.797, 0.131, 0.046},
                        p3[6] = {0.680, 0.320, 0.265, 0.690, 0.150, 0.060};
    const double *primaries = data[0] == 9 ? bt2020 : data[0] == 12 ? p3 : bt709;
    FfpColourProfile profile = {.kind = FFP_PROFILE_NUMBERS, .white = {0.3127, 0.3290}};
    profile.gamma = data[1] == 4 ? 2.2 : data[1] == 5 ? 2.8 : data[1] == 8 ? 1 : 0;
    profile.hdr = data[1] == 16 || data[1] == 18;
    memcpy(profile.primaries, primaries, sizeof profile.primaries);
    return profile;
}

// gAMA, and cHRM where it has any: in 1/100000.
static FfpColourProfile of_gamma(const unsigned char *gamma, const unsigned char *points) {
    FfpColourProfile profile = {.kind = FFP_PROFILE_NUMBERS,
                                .white = {0.3127, 0.3290},
                                .primaries = {0.64, 0.33, 0.30, 0.60, 0.15, 0.06}};
    const uint32_t value = gamma ? big32(gamma) : 45455;
    if (value == 0) return (FfpColourProfile){0};
    // 1/2.2 is what programs write that mean sRGB
    profile.gamma = value > 45000 && value < 46000 ? 0 : 100000.0 / value;
    for (int i = 0; points && i < 2; i++) profile.white[i] = big32(points + 4 * i) / 100000.0;
    for (int i = 0; points && i < 6; i++) profile.primaries[i] = big32(points + 8 + 4 * i) / 100000.0;
    return profile;
}

// Cameras set to Adobe RGB put no profile into their pictures (Adobe RGB (1998), 4.3.1).
static FfpColourProfile of_exif(const unsigned char *bytes, size_t size) {
    if (!ffp_exif_is_adobe_rgb(bytes, size)) return (FfpColourProfile){0};
    return (FfpColourProfile){.kind = FFP_PROFILE_NUMBERS,
                              .gamma = 563.0 / 256,
                              .white = {0.3127, 0.3290},
                              .primaries = {0.64, 0.33, 0.21, 0.71, 0.15, 0.06},
                              .name = "Adobe RGB, as its EXIF data say,"};
}

// By the order of the specification (PNG third edition, 4.3): cICP, iCCP, sRGB, cHRM and gAMA.
static FfpColourProfile find_in_png(const FfpEncoded *file) {
    enum { KINDS = 6 };
    static const struct {
        const char *name;
        uint32_t least;
    } kinds[KINDS] = {{"cICP", 4}, {"iCCP", 4}, {"sRGB", 1}, {"gAMA", 4}, {"cHRM", 32}, {"eXIf", 8}};
    const unsigned char *found[KINDS] = {NULL};
    size_t lengths[KINDS] = {0};
    for (size_t at = PNG_BEGIN; at + CHUNK <= file->size;) {
        const unsigned char *chunk = file->data + at;
        const size_t length = big32(chunk);
        if (length > file->size - at - CHUNK || memcmp(chunk + 4, "IDAT", 4) == 0) break;
        for (int k = 0; k < KINDS; k++)
            if (memcmp(chunk + 4, kinds[k].name, 4) == 0 && length >= kinds[k].least) {
                found[k] = chunk + 8;
                lengths[k] = length;
            }
        at += CHUNK + length;
    }
    if (found[0]) return of_code_points(found[0]);
    if (found[1]) return unpack(found[1], lengths[1]);
    if (found[2]) return (FfpColourProfile){0};
    return found[3] || found[4] ? of_gamma(found[3], found[4]) : of_exif(found[5], lengths[5]);
}

// APP2 "ICC_PROFILE": its number of how many, from 1, and a part of the profile. Or APP1 "Exif".
static FfpColourProfile find_in_jpeg(const FfpEncoded *file) {
    static const char mark[12] = "ICC_PROFILE", exif_mark[6] = "Exif\0";
    FfpColourProfile by_exif = {0};
    unsigned char *bytes = NULL;
    size_t size = 0;
    int next = 1;
    for (size_t at = 2; at + 4 <= file->size && file->data[at] == 0xff;) {
        const unsigned char *segment = file->data + at;
        const size_t length = (size_t)segment[2] << 8 | segment[3];
        if (segment[1] == 0xff) {
            at++;
            continue;
        }
        if (segment[1] == 0xda || length < 2 || length > file->size - at - 2) break;
        if (segment[1] == 0xe2 && length > PARTS_HEAD + 2 && memcmp(segment + 4, mark, sizeof mark) == 0 &&
            segment[16] == next) {
            const size_t more = length - 2 - PARTS_HEAD;
            bytes = ffp_grow(bytes, size + more, 1);
            memcpy(bytes + size, segment + 4 + PARTS_HEAD, more);
            size += more;
            next++;
        }
        if (segment[1] == 0xe1 && length > 8 && memcmp(segment + 4, exif_mark, sizeof exif_mark) == 0)
            by_exif = of_exif(segment + 10, length - 8);
        at += 2 + length;
    }
    FfpColourProfile profile = ffp_profile_of_icc(bytes, size);
    ffp_free(bytes);
    return profile.kind == FFP_PROFILE_NONE ? by_exif : profile;
}

// ICCP, which follows the header of files that have it: its name, its length, the profile.
static FfpColourProfile find_in_webp(const FfpEncoded *file) {
    enum { AT = 30, HEAD = 8 };
    if (file->size < AT + HEAD || memcmp(file->data + AT, "ICCP", 4) != 0) return (FfpColourProfile){0};
    const unsigned char *chunk = file->data + AT;
    const size_t length = chunk[4] | (size_t)chunk[5] << 8 | (size_t)chunk[6] << 16 | (size_t)chunk[7] << 24;
    return ffp_profile_of_icc(chunk + HEAD, length > file->size - AT - HEAD ? 0 : length);
}

FfpColourProfile ffp_profile_find(const FfpEncoded *file) {
    if (file->size > 8 && memcmp(file->data, "\x89PNG", 4) == 0) return find_in_png(file);
    if (file->size > 3 && memcmp(file->data, "\xff\xd8\xff", 3) == 0) return find_in_jpeg(file);
    if (file->size > 16 && memcmp(file->data + 8, "WEBPVP8X", 8) == 0) return find_in_webp(file);
    return of_exif(file->data, file->size); // a TIFF begins as EXIF data do
}
