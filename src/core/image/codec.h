// The file formats behind image.h. Each reader takes the whole file in memory; the content decides which
// reader is used. Sizes are those of the displayed picture, after applying the orientation tag.
#ifndef FFP_IMAGE_CODEC_H
#define FFP_IMAGE_CODEC_H

#include <stddef.h>
#include "core/image/image.h"

// A file's description of its colours (profile.h).
typedef enum FfpProfileKind { FFP_PROFILE_NONE, FFP_PROFILE_ICC, FFP_PROFILE_NUMBERS } FfpProfileKind;
typedef struct FfpColourProfile {
    FfpProfileKind kind;
    unsigned char *icc; // [size]
    size_t size;
    double gamma;                  // light is the value to this power; 0: sRGB's curve
    double white[2], primaries[6]; // CIE x y
    bool hdr;                      // HLG or PQ
    const char *name;              // NULL: it has none
} FfpColourProfile;

typedef struct FfpDecoded {
    FfpImage image; // RGBA as stored; if linear, premultiplied; otherwise encoded, in [0,1], straight alpha
    bool linear;    // an EXR, or a TIFF of floats
    bool has_alpha;
    FfpColourProfile profile; // to be released
    bool inks;                // it was of inks, and is converted already
    int orientation;          // 1 to 8, how the stored picture is to be shown (orientation.c); 0: as it is
} FfpDecoded;

// A file in memory; `path` is for error messages.
typedef struct FfpEncoded {
    const unsigned char *data;
    size_t size;
    const char *path;
} FfpEncoded;

bool ffp_png_is(const FfpEncoded *file);
bool ffp_png_size(const FfpEncoded *file, int *width, int *height, FfpError *err);
bool ffp_png_decode(const FfpEncoded *file, FfpDecoded *out, FfpError *err);
bool ffp_png_decode_raw(const FfpEncoded *file, FfpDecoded *out,
                        FfpError *err); // 1 channel of integers; grey files only

bool ffp_jpeg_is(const FfpEncoded *file);
bool ffp_jpeg_size(const FfpEncoded *file, int *width, int *height, FfpError *err);
bool ffp_jpeg_decode(const FfpEncoded *file, FfpDecoded *out, FfpError *err);
// The light of a picture of 1 / shrink its size: means over shrink x shrink pixels. out->image: RGB, linear.
// It stays empty where the picture is one of inks.
typedef struct FfpReduction {
    int shrink;
    bool rough;        // means may be those of encoded values, which takes less time
    const real *light; // [256] of a value
} FfpReduction;
bool ffp_jpeg_decode_reduced(const FfpEncoded *file, const FfpReduction *reduction, FfpDecoded *out,
                             FfpError *err);

bool ffp_tiff_is(const FfpEncoded *file);
bool ffp_tiff_size(const FfpEncoded *file, int *width, int *height, FfpError *err);
bool ffp_tiff_decode(const FfpEncoded *file, FfpDecoded *out, FfpError *err);
bool ffp_tiff_decode_raw(const FfpEncoded *file, FfpDecoded *out,
                         FfpError *err); // 1 channel of integers or floats; grey files only

bool ffp_exr_is(const FfpEncoded *file);
bool ffp_exr_size(const FfpEncoded *file, int *width, int *height, FfpError *err);
bool ffp_exr_decode(const FfpEncoded *file, FfpDecoded *out, FfpError *err);
bool ffp_exr_decode_raw(const FfpEncoded *file, FfpDecoded *out,
                        FfpError *err); // Z, otherwise Y, in whichever layer, otherwise the first channel

// Fails with the name of a format that this program does not read, and what to do about it; always false.
bool ffp_refuse_foreign(const FfpEncoded *file, FfpError *err);
bool ffp_is_foreign(const FfpEncoded *file); // a known one, by its first bytes
typedef enum FfpForeign {
    FFP_FOREIGN_OTHER, // or not foreign at all
    FFP_FOREIGN_RAW,   // a camera's own format
    FFP_FOREIGN_FILM
} FfpForeign;
FfpForeign ffp_foreign_kind(const FfpEncoded *head); // 512 bytes are enough
bool ffp_tiff_is_raw(const FfpEncoded *file);        // DNG, NEF, ARW and the like, which are TIFF files

// The orientation tag (1 to 8) of EXIF data, which begin with a TIFF header; 1 where there is none.
int ffp_exif_orientation(const unsigned char *bytes, size_t size);
FfpTakenBy ffp_exif_taken_by(const unsigned char *bytes, size_t size);
// True if they say Adobe RGB: by the colour space 2 of some cameras, or by "R03" as their rule of
// interoperability (DCF 2.0, JEITA CP-3461B).
bool ffp_exif_is_adobe_rgb(const unsigned char *bytes, size_t size);
// Rotates or mirrors a picture as the tag says, into new memory or given memory of its size, and likewise a
// size given by a file.
void ffp_orient(FfpImage *image, int orientation);
void ffp_orient_into(real *out, const FfpImage *image, int orientation);
void ffp_orient_size(int *width, int *height, int orientation);

// Refuses a side of 0 or above FFP_IMAGE_SIDE_MAX.
bool ffp_check_sides(long long width, long long height, const char *path, FfpError *err);

#endif
