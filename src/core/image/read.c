// Reading an image file: take it into memory, see what it is, hand it to its codec.
#define _GNU_SOURCE // memmem
#include <string.h>
#include <strings.h>
#include "core/base/file.h"
#include "core/base/kind.h"
#include "core/base/log.h"
#include "core/image/profile.h"

#define FILE_BYTES_MAX ((size_t)1 << 30)

static bool read_bytes(FfpEncoded *file, const char *path, FfpError *err) {
    char *data = NULL;
    *file = (FfpEncoded){.path = path};
    if (!ffp_read_file(path, FILE_BYTES_MAX, &data, &file->size, err)) return false;
    file->data = (const unsigned char *)data;
    if (file->size > 0) return true;
    ffp_free(data);
    file->data = NULL;
    ffp_fail(err, FFP_ERROR_FILE, path, "file is empty");
    return false;
}

static void free_bytes(FfpEncoded *file) {
    ffp_free((void *)file->data);
}

typedef struct Codec {
    bool (*is)(const FfpEncoded *file);
    bool (*size)(const FfpEncoded *file, int *width, int *height, FfpError *err);
    bool (*decode)(const FfpEncoded *file, FfpDecoded *out, FfpError *err);
    bool (*decode_raw)(const FfpEncoded *file, FfpDecoded *out, FfpError *err); // NULL: holds no raw numbers
} Codec;

static const Codec codecs[] = {
    {ffp_png_is, ffp_png_size, ffp_png_decode, ffp_png_decode_raw},
    {ffp_jpeg_is, ffp_jpeg_size, ffp_jpeg_decode, NULL},
    {ffp_exr_is, ffp_exr_size, ffp_exr_decode, ffp_exr_decode_raw},
    {ffp_tiff_is, ffp_tiff_size, ffp_tiff_decode, ffp_tiff_decode_raw},
};

// NULL with an error. Some raw photographs look like TIFF files.
static const Codec *codec_of(const FfpEncoded *file, FfpError *err) {
    for (size_t i = 0; i < sizeof codecs / sizeof *codecs && !ffp_is_foreign(file); i++) {
        if (codecs[i].is(file)) return &codecs[i];
    }
    if (ffp_check_kind(file->path, FFP_WANTED_IMAGE, err)) ffp_refuse_foreign(file, err);
    return NULL;
}

static bool has_size(const Codec *codec, const FfpEncoded *file, const FfpSize *size, FfpError *err) {
    int width = 0, height = 0;
    return codec->size(file, &width, &height, err) && ffp_size_check(size, width, height, file->path, err);
}

static void note_orientation(FfpDecoded *out, const char *path) {
    if (out->orientation < 2) return;
    ffp_orient(&out->image, out->orientation);
    ffp_note("%s: %s, as its orientation tag says", path, ffp_orientation_words(out->orientation));
}

typedef enum Wanted {
    NUMBERS, // one channel as it stands, rather than RGBA
    VALUES,  // RGBA as it stands
    COLOURS  // in sRGB, if they are not linear
} Wanted;

static void take_profile(FfpDecoded *out, const FfpEncoded *file) {
    if (out->profile.kind == FFP_PROFILE_NONE) out->profile = ffp_profile_find(file);
    if (!out->linear && !out->inks) ffp_profile_apply(&out->profile, &out->image, file->path);
}

// `size`: that it is to have; NULL: any.
static bool decode(FfpDecoded *out, const char *path, Wanted wanted, const FfpSize *size, FfpError *err) {
    const bool raw = wanted == NUMBERS;
    *out = (FfpDecoded){0};
    FfpEncoded file;
    if (!read_bytes(&file, path, err)) return false;
    const Codec *codec = codec_of(&file, err);
    bool ok = codec && (!size || has_size(codec, &file, size, err));
    if (ok && raw && !codec->decode_raw)
        ok = ffp_fail(err, FFP_ERROR_FILE, path, "is not a grey PNG or TIFF, or an EXR image");
    else if (ok)
        ok = (raw ? codec->decode_raw : codec->decode)(&file, out, err);
    if (ok && wanted == COLOURS) take_profile(out, &file);
    ffp_free(out->profile.icc);
    out->profile = (FfpColourProfile){0};
    free_bytes(&file);
    if (ok) note_orientation(out, path);
    // The size that was decoded counts, whatever the header said.
    if (ok && size && !ffp_size_check(size, out->image.width, out->image.height, path, err)) {
        ffp_image_free(&out->image);
        return false;
    }
    return ok;
}

// Where a file's EXIF data begin, and their size; 0: there are none, or it cannot be read. To be released.
static size_t read_exif(FfpEncoded *file, const char *path, const unsigned char **exif) {
    enum { HEAD = 1 << 18 }; // a JPEG's tags come first
    static const char mark[6] = "Exif\0";
    FfpError unread = {0};
    *exif = NULL;
    if (!read_bytes(file, path, &unread)) return 0;
    if (ffp_tiff_is(file)) *exif = file->data;
    if (ffp_jpeg_is(file)) {
        const unsigned char *at =
            memmem(file->data, file->size < HEAD ? file->size : HEAD, mark, sizeof mark);
        if (at) *exif = at + sizeof mark;
    }
    return *exif ? (size_t)(file->data + file->size - *exif) : 0;
}

int ffp_image_orientation(const char *path) {
    FfpEncoded file;
    const unsigned char *exif;
    const size_t size = read_exif(&file, path, &exif);
    const int orientation = ffp_exif_orientation(exif, size);
    free_bytes(&file);
    return orientation;
}

FfpTakenBy ffp_image_taken_by(const char *path) {
    FfpEncoded file;
    const unsigned char *exif;
    const size_t size = read_exif(&file, path, &exif);
    const FfpTakenBy by = ffp_exif_taken_by(exif, size);
    free_bytes(&file);
    return by;
}

// Premultiplied to straight alpha; where alpha is 0 the colour stays as it is.
static void unpremultiply(FfpImage *image) {
    const ptrdiff_t pixels = (ptrdiff_t)image->width * image->height;
    for (ptrdiff_t i = 0; i < pixels; i++) {
        real *p = image->data + 4 * i;
        for (int c = 0; c < 3 && p[3] > 0; c++) p[c] /= p[3];
    }
}

bool ffp_image_read_sized(FfpImage *image, const char *path, FfpColour colour, const FfpSize *size,
                          FfpError *err) {
    FfpDecoded decoded;
    *image = (FfpImage){0};
    if (!decode(&decoded, path, colour == FFP_COLOUR_STORED ? VALUES : COLOURS, size, err)) return false;
    if (decoded.linear) unpremultiply(&decoded.image);
    if (decoded.linear && colour == FFP_COLOUR_ENCODED) ffp_image_to_srgb(&decoded.image);
    if (!decoded.linear && colour == FFP_COLOUR_LINEAR) ffp_image_to_linear(&decoded.image);
    *image = decoded.image;
    return true;
}

bool ffp_image_read(FfpImage *image, const char *path, FfpColour colour, FfpError *err) {
    return ffp_image_read_sized(image, path, colour, NULL, err);
}

// `light`: the numbers of files that are not linear are taken for linear ones.
static bool read_over_black(FfpImage *rgb, FfpImage *alpha, const char *path, bool light, const FfpSize *size,
                            FfpError *err) {
    FfpDecoded decoded;
    *rgb = (FfpImage){0};
    if (alpha) *alpha = (FfpImage){0};
    if (!decode(&decoded, path, light ? VALUES : COLOURS, size, err)) return false;
    FfpImage *image = &decoded.image;
    if (decoded.has_alpha && alpha) *alpha = ffp_image_channel(image, 3);
    if (decoded.linear) {
        // Premultiplied is over black already; alpha must not be multiplied in a second time.
        const ptrdiff_t pixels = (ptrdiff_t)image->width * image->height;
        for (ptrdiff_t i = 0; i < pixels; i++) image->data[4 * i + 3] = 1;
    }
    ffp_image_put_over_black(image);
    *rgb = *image;
    if (!decoded.linear && !light) ffp_image_to_linear(rgb);
    return true;
}

// True if it has other colours than sRGB that are to be converted.
static bool is_profiled(const FfpEncoded *file) {
    FfpColourProfile profile = ffp_profile_find(file);
    const bool profiled = !ffp_profile_is_srgb(&profile);
    ffp_free(profile.icc);
    return profiled;
}

// A JPEG's, reduced while it is decoded; *done false, without an error: of any other file.
static bool reduce_jpeg(FfpImage *rgb, int whole[2], bool *done, const char *path, bool light, int shrink,
                        bool rough, FfpError *err) {
    FfpEncoded file;
    FfpDecoded out = {0};
    real table[256];
    *done = false;
    if (!read_bytes(&file, path, err)) return false;
    bool ok = true;
    if (ffp_jpeg_is(&file) && (light || !is_profiled(&file))) {
        for (int i = 0; i < 256; i++) table[i] = light ? (real)i / 255 : ffp_srgb_decode((real)i / 255);
        ok = ffp_jpeg_size(&file, &whole[0], &whole[1], err);
        if (ok && whole[0] % shrink == 0 && whole[1] % shrink == 0)
            ok = ffp_jpeg_decode_reduced(&file, &(FfpReduction){shrink, rough, table}, &out, err);
    }
    free_bytes(&file);
    *done = ok && out.image.data;
    if (*done) note_orientation(&out, path);
    *rgb = out.image;
    return ok;
}

void ffp_image_reduce(FfpImage *image, int shrink) {
    if (shrink == 1) return;
    FfpImage out = ffp_image_new(image->width / shrink, image->height / shrink, image->channels);
    const size_t n = (size_t)image->channels;
    const real pixels = (real)(shrink * shrink);
    for (int y = 0; y < image->height; y++)
        for (int x = 0; x < image->width; x++) {
            real *to = out.data + n * ((size_t)(y / shrink) * (size_t)out.width + (size_t)(x / shrink));
            const real *from = image->data + n * ((size_t)y * (size_t)image->width + (size_t)x);
            for (size_t c = 0; c < n; c++) to[c] += from[c] / pixels;
        }
    ffp_image_free(image);
    *image = out;
}

bool ffp_image_read_reduced(FfpImage *rgb, FfpImage *alpha, int whole[2], const char *path, bool light,
                            int shrink, bool rough, FfpError *err) {
    bool done = false;
    *rgb = (FfpImage){0};
    if (alpha) *alpha = (FfpImage){0};
    if (!reduce_jpeg(rgb, whole, &done, path, light, shrink, rough, err)) return false;
    if (done) return true;
    if (!read_over_black(rgb, alpha, path, light, NULL, err)) return false;
    whole[0] = rgb->width, whole[1] = rgb->height;
    if (whole[0] % shrink != 0 || whole[1] % shrink != 0) return true;
    ffp_image_reduce(rgb, shrink);
    if (alpha && alpha->data) ffp_image_reduce(alpha, shrink);
    return true;
}

bool ffp_image_read_over_black(FfpImage *rgb, FfpImage *alpha, const char *path, FfpError *err) {
    return read_over_black(rgb, alpha, path, false, NULL, err);
}

bool ffp_image_read_over_black_sized(FfpImage *rgb, FfpImage *alpha, const char *path, const FfpSize *size,
                                     FfpError *err) {
    return read_over_black(rgb, alpha, path, false, size, err);
}

bool ffp_image_read_light(FfpImage *rgb, FfpImage *alpha, const char *path, FfpError *err) {
    return read_over_black(rgb, alpha, path, true, NULL, err);
}

bool ffp_image_read_raw16(FfpImage *image, const char *path, const FfpSize *size, FfpError *err) {
    FfpDecoded decoded;
    const bool ok = decode(&decoded, path, NUMBERS, size, err);
    *image = decoded.image;
    return ok;
}

bool ffp_image_has_ending(const char *name) {
    static const char *const endings[] = {".png", ".jpg", ".jpeg", ".tif", ".tiff", ".exr"};
    const char *dot = strrchr(name, '.');
    for (size_t i = 0; dot && dot != name && i < sizeof endings / sizeof *endings; i++) {
        if (strcasecmp(dot, endings[i]) == 0) return true;
    }
    return false;
}

bool ffp_image_read_size(int *width, int *height, const char *path, FfpError *err) {
    *width = *height = 0;
    FfpEncoded file;
    if (!read_bytes(&file, path, err)) return false;
    const Codec *codec = codec_of(&file, err);
    const bool ok = codec && codec->size(&file, width, height, err);
    free_bytes(&file);
    return ok;
}
