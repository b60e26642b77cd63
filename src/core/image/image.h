// Float images in memory, and the files they come from.
#ifndef FFP_IMAGE_IMAGE_H
#define FFP_IMAGE_IMAGE_H

#include <stdbool.h>
#include <stddef.h>
#include "core/base/error.h"
#include "core/base/real.h"
#include "core/image/srgb_formula.h"

#define FFP_IMAGE_SIDE_MAX 16384

typedef struct FfpImage {
    int width, height, channels;
    real *data; // [height, width, channels], owned; NULL: no image
} FfpImage;

// These three work on the device that the thread uses (core/base/device.h), by default the CPU; all others
// here work on the CPU.
FfpImage ffp_image_new(int width, int height, int channels); // zeroed; sizes must be checked by the caller
void ffp_image_free(FfpImage *image);                        // also clears it; NULL and empty are allowed
FfpImage ffp_image_copy(const FfpImage *image);
double ffp_image_mean(const FfpImage *image); // of all values

// A picture whose rows are made when they are needed, so that a large one is never in memory as a whole.
typedef struct FfpRows {
    int width, height, channels;
    void (*make)(void *context, int y, real *row); // writes row y, [width, channels]; any thread may call it
    void *context;
} FfpRows;

// The size that a file must have and, for the message, whose size it is: of "camera", in "scene.json". A file
// of another size is an error. The header is checked before anything is decoded, so that a huge file takes no
// memory; the file is read only once.
typedef struct FfpSize {
    int width, height;
    const char *of, *in;
} FfpSize;

// How the colours of a file are interpreted when it is read.
typedef enum FfpColour {
    FFP_COLOUR_ENCODED, // as they are in the file, scaled to [0,1] (linear files are sRGB-encoded, so
                        // clamped)
    FFP_COLOUR_LINEAR,  // sRGB files decoded to linear
    FFP_COLOUR_STORED,  // unchanged from any file, integers scaled to [0,1]: for numbers that are not
                        // colours
} FfpColour;

// Reads PNG (8/16 bit, grey, RGB, with or without alpha, palette), JPEG (CMYK too), TIFF (8/16 bit, floats)
// or EXR (lines or tiles, layers, parts) by its content, not its name. EXR and TIFF of floats are linear.
// JPEG and TIFF are rotated as their orientation tag says, with a note. Returns 4 channels: RGB and straight
// alpha (1 if the file has none). Errors: not a file, not an image, truncated, a side of 0 or above
// FFP_IMAGE_SIDE_MAX, values that are not finite. Colours of files with another
// profile than sRGB are converted, with a note, but not for FFP_COLOUR_STORED.
bool ffp_image_read(FfpImage *image, const char *path, FfpColour colour, FfpError *err);
// Linear RGB over black. Straight alpha is multiplied in before decoding (as pictures are composited in
// viewers, and in the metrics of this field); a linear file's colours are already premultiplied. *alpha
// receives the alpha channel, or stays empty if the file has none; alpha may be NULL.
bool ffp_image_read_over_black(FfpImage *rgb, FfpImage *alpha, const char *path, FfpError *err);
// The same for files whose numbers are linear light, whatever their kind: nothing is decoded.
bool ffp_image_read_light(FfpImage *rgb, FfpImage *alpha, const char *path, FfpError *err);
// Either (`light`: the second) at 1 / shrink of its size: means of linear light over shrink x shrink pixels,
// in `rough` JPEG files of encoded values, which takes less time. `whole`: the file's width and height; where
// shrink does not divide both, the picture is not reduced.
bool ffp_image_read_reduced(FfpImage *rgb, FfpImage *alpha, int whole[2], const char *path, bool light,
                            int shrink, bool rough, FfpError *err);
// One channel as raw numbers: 0..65535 of a 16-bit grey PNG or TIFF (0..255 of an 8-bit one), a grey TIFF's
// floats, or an EXR's Z, Y or first channel: depth and roughness maps. `size` may be NULL.
bool ffp_image_read_raw16(FfpImage *image, const char *path, const FfpSize *size, FfpError *err);
// The pictures above with a size.
bool ffp_image_read_sized(FfpImage *image, const char *path, FfpColour colour, const FfpSize *size,
                          FfpError *err);
bool ffp_image_read_over_black_sized(FfpImage *rgb, FfpImage *alpha, const char *path, const FfpSize *size,
                                     FfpError *err);
bool ffp_size_check(const FfpSize *size, int width, int height, const char *path, FfpError *err);

// True if a name has the extension of a format above: for finding the pictures among a folder's files.
bool ffp_image_has_ending(const char *name);
// The orientation tag of a JPEG or TIFF, 1 to 8; 1: there is none, or the file cannot be read.
int ffp_image_orientation(const char *path);
// A camera's own words in a JPEG or TIFF (EXIF); "" and 0: it does not say, or the file cannot be read.
enum { FFP_TAKEN_TEXT = 64 };
typedef struct FfpTakenBy {
    char model[FFP_TAKEN_TEXT], serial[FFP_TAKEN_TEXT], lens[FFP_TAKEN_TEXT]; // serial: number of the body
    double focal_35mm, focal; // length, mm: as that of a 35 mm camera, and the lens's own
    double zoom;              // digital; 1: none
} FfpTakenBy;
FfpTakenBy ffp_image_taken_by(const char *path);
const char *ffp_orientation_words(int orientation); // "turned by 180 degrees"; 1: ""
// Only the size, after applying the orientation tag, without decoding: for checks before memory is allocated.
bool ffp_image_read_size(int *width, int *height, const char *path, FfpError *err);

// 8-bit PNG of 1, 3 or 4 channels; values must be encoded, and are clamped to [0,1] and rounded.
bool ffp_image_write_png(const FfpImage *image, const char *path, FfpError *err);
bool ffp_image_write_png16(const FfpImage *image, const char *path,
                           FfpError *err); // values in [0,1] -> 0..65535
// The same from rows that are made when they are needed, each twice; `depth`: 8 or 16 bits.
bool ffp_image_write_png_rows(const FfpRows *rows, int depth, const char *path, FfpError *err);
// A linear RGB picture as an 8-bit sRGB PNG.
bool ffp_image_write_png_encoded(const FfpImage *linear, const char *path, FfpError *err);
// 8-bit JPEG of 3 channels, clamped and rounded likewise, with a quality of 1 to 100 by libjpeg's scale and
// half as many pixels of colour each way, as cameras write it. Errors: other channels or quality, a file that
// cannot be written.
bool ffp_image_write_jpeg(const FfpImage *image, int quality, const char *path, FfpError *err);
// The same 8-bit PNG as above into memory (released with ffp_free): for reports.
bool ffp_image_encode_png(const FfpImage *image, unsigned char **bytes, size_t *size, FfpError *err);
// 32-bit float EXR with channels named R G B [A], Y, or Z for one channel called depth.
bool ffp_image_write_exr(const FfpImage *image, const char *path, FfpError *err);

// Linear radiance of the part of a pixel that the object covers, from the photograph's value over black: the
// photograph's encoded value is coverage (in [0,1]) times that of the object's own colour.
void ffp_own_radiance(real own[3], const real shown[3], real coverage);
// The inverse, from coverage times that radiance; both may be the same array.
void ffp_shown_radiance(real shown[3], const real light[3], real coverage);
// In place, RGB channels only (a fourth channel stays). On a device too.
void ffp_image_to_srgb(FfpImage *image);
void ffp_image_to_linear(FfpImage *image);

// RGB times alpha: turns a 4-channel image into a 3-channel one over black, in its own memory.
void ffp_image_put_over_black(FfpImage *image);
FfpImage ffp_image_channel(const FfpImage *image, int channel);
// The object's share of each pixel according to a mask's file, one channel: grey times alpha.
FfpImage ffp_mask_of(const FfpImage *rgba);
// Multiplies a linear RGB picture by a mask of its size, in encoded values as everywhere; an empty picture
// stays empty.
void ffp_mask_apply(const FfpImage *mask, FfpImage *image);
// Area-averaging (down) or bilinear (up) resize, decided for each axis.
FfpImage ffp_image_resize(const FfpImage *image, int width, int height);
FfpImage ffp_image_resize_rows(const FfpRows *rows, int width, int height);

// Through a Gaussian of this deviation in pixels, to three of them, in place; edges are repeated. 0:
// unchanged.
void ffp_image_blur(FfpImage *image, real deviation);

// image <- (1 - share) image + share (image through a Gaussian of this deviation in pixels), a channel of
// three, in place; edges are repeated, and a picture of one colour stays as it is. The Gaussian is of a
// reduced picture, exact to a hundredth of its height. Deviation 0: unchanged.
void ffp_image_spread(FfpImage *image, const real share[3], real deviation);

// Means over shrink x shrink pixels, in place of the picture; shrink divides its sides.
void ffp_image_reduce(FfpImage *image, int shrink);

// Bilinear sample at (u,v) in pixels, centres at +0.5, edge clamped, into out[channels].
void ffp_image_sample(const FfpImage *image, real u, real v, real *out);

#endif
