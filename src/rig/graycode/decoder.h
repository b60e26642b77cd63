// The common state of this room's files: a view that is being decoded.
#ifndef FFP_GRAYCODE_DECODER_H
#define FFP_GRAYCODE_DECODER_H

#include <stddef.h>
#include <stdint.h>
#include "rig/graycode/graycode.h"

#define FFP_GRAY_LIT 0.003    // linear light, that white adds to black where a code can be read
#define FFP_GRAY_CLIPPED 0.98 // linear: at the camera's limit

enum {
    FFP_GRAY_BITS_MAX = 15,
    FFP_GRAY_WEAK = 15 // of 127: a code's bit is not told from its inverse
};

typedef struct FfpGrayDecoder {
    const FfpGrayPhotographs *from;
    int width, height, bits[2]; // of the photographs; that number columns and rows
    size_t pixels;
    float *light;                          // [h,w] grey, white - black; 0 where a pixel is not lit
    float *black;                          // [h,w]
    unsigned char *checked;                // [h,w] lit well, and in the region: what checks are made on
    uint8_t *signal[2][FFP_GRAY_BITS_MAX]; // [h,w] ffp_gray_signal
    int *code[2];                          // [h,w] blocks; -1: not decoded
    uint8_t
        *weakest[2]; // [h,w,2] of the pair with the least contrast: that, 1/254, and its sum, 1/127 of white
    int missing[2];  // finest bits from the first that is missing on
    int dropped[2];
    FfpGrayReport *report;
} FfpGrayDecoder;

// Its file; of a missing one that of its pair; NULL: both are missing. And whether it exists.
const char *ffp_gray_photograph(const FfpGrayDecoder *d, int axis, int bit, int inverse);
bool ffp_gray_has_photograph(const FfpGrayDecoder *d, int axis, int bit, int inverse);

// Puts what black or white is missing onto the cache, made from the codes, and names it.
bool ffp_gray_make_plain(FfpGrayPhotographs *photographs, FfpError *err);

// At 1 / shrink of its size (0: as it is): mean of a file's channels as linear light, [h,w], released with
// ffp_free; its luma and the mean of each channel where they are not NULL.
bool ffp_gray_read(float **grey, FfpImage *luma, double colour[3], int *width, int *height, const char *path,
                   bool linear, int shrink, FfpError *err);

// Light, black, and where checks are made. Errors: another size, too little light.
bool ffp_gray_find_light(FfpGrayDecoder *d, FfpError *err);

// Every pair of photographs, checked, as signals. Errors: another size or exposure, no pairs.
bool ffp_gray_read_signals(FfpGrayDecoder *d, FfpError *err);

// Adds a pair of photographs to the figures; colours: their channels' means. And what all pairs tell, with
// the map of positions.
void ffp_gray_see_pair(FfpGrayDecoder *d, int axis, int bit, float *const grey[2],
                       const double colours[2][3]);
void ffp_gray_see_panel(FfpGrayDecoder *d, const FfpImage *map);
// Findings of what is wrong with a view's settings.
void ffp_gray_tell_figures(const FfpGrayFigures *figures, const char *view);

// The error of a set of which there are only the first `n` codes, with black and white: what is wrong with
// them, or their number. Findings that they allow are told. Returns false.
bool ffp_gray_fail_few(const FfpGrayPhotographs *photographs, int n, FfpError *err);

// The finest bits that most pixels cannot tell.
void ffp_gray_drop_fine_bits(FfpGrayDecoder *d, int axis);

// Checks that an axis' photographs are in order, by its signals and the codes made from them (also those
// beyond the panel); the other axis' codes, which must have been found before, show where a surface
// continues. The error names the two photographs or pairs that have changed places, if one such exchange
// explains everything.
bool ffp_gray_check_order(const FfpGrayDecoder *d, int axis, FfpError *err);

#endif
