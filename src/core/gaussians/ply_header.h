// The text at the head of a PLY file: which bytes of a row hold which of our numbers.
#ifndef FFP_GAUSSIANS_PLY_HEADER_H
#define FFP_GAUSSIANS_PLY_HEADER_H

#include <stdio.h>
#include "core/base/error.h"
#include "core/gaussians/row.h"

typedef struct FfpPlyHeader {
    int64_t count;
    int stride;                  // bytes of a row
    int offset[FFP_ROW_NUMBERS]; // of each number in a row, or -1
    unsigned wide;               // bit i: number i is a double in the file, otherwise a float
    bool plain;                  // splats of other programs: without albedo and roughness
    bool flat;                   // discs (2DGS): without the third scale
    char made_from[FFP_MADE_FROM];
    FfpBakedShadows baked;
} FfpPlyHeader;

// Reads up to and including the line "end_header". Accepts one element "vertex" with scalar properties in any
// order, ignoring unknown ones; base_color_0..2 together with roughness, and scale_2, may be missing
// (`plain`, `flat`). Errors: not a PLY, not binary little-endian, lists, other elements, any other property
// that is missing, a property that is duplicate or not a float, a count that is not a number or above
// FFP_GAUSSIANS_MAX.
bool ffp_ply_header_read(FfpPlyHeader *header, FILE *stream, const char *path, FfpError *err);
// That of `count` of the Gaussians.
void ffp_ply_header_write(FILE *stream, int64_t count, const FfpGaussians *gaussians);

#endif
