// Gray codes of one attitude: which place of the projector's panel each camera pixel sees.
#ifndef FFP_CALIBRATE_CODES_H
#define FFP_CALIBRATE_CODES_H

#include "image/image.h"

// A picture as camera values, sRGB-encoded luminance in [0,1]. [height,width,1]
bool ffp_read_grey(FfpImage *grey, const char *path, FfpError *err);

// Photographs of one attitude in the order in which they were shown: the projector black and white (which
// first does not matter, and both may stand before or behind the codes), and for each bit of columns, then of
// rows, the coarsest first, the code and its inverse (patterns.h).
typedef struct FfpCodeShots {
    const char *const *files;
    int n_files;
    int width, height; // of the projector's panel
} FfpCodeShots;

// How many photographs there must be.
int ffp_code_shots_count(int width, int height);

// Which files are black and white, told by the light: white is brighter wherever the projector's light falls.
// Reads the two first and the two last. `black`, `white`: the pictures; `first`: index of the first code.
// Errors: another number of photographs, pictures of other sizes, no pair of which one is everywhere the
// brighter.
bool ffp_code_shots_open(const FfpCodeShots *shots, FfpImage *black, FfpImage *white, int *first,
                         FfpError *err);

// What was decoded. A pixel of which a bit is in doubt, between two stripes or in the dark, has none.
typedef struct FfpCodeMap {
    int width, height;   // of the camera's pictures
    float *column, *row; // [height,width] projector pixels, centres at integers; -1: none
    int lost[2];         // finest bits of columns and rows that the camera could not tell anywhere
} FfpCodeMap;

// Decodes. `region` [height,width] says where it is looked at whether the pictures belong together: the
// board. Errors: a picture of another size or exposure; pictures that are not each other's inverse.
bool ffp_code_map_read(FfpCodeMap *map, const FfpCodeShots *shots, int first, const FfpImage *black,
                       const FfpImage *white, const unsigned char *region, FfpError *err);
void ffp_code_map_free(FfpCodeMap *map);

#endif
