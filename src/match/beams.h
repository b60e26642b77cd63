// What a projector's light says about space: up to where it first meets a surface, it is empty.
#ifndef FFP_MATCH_BEAMS_H
#define FFP_MATCH_BEAMS_H

#include "match/consistency.h"

// The trusted points of a view on a grid of its projector's picture; a cell is about as wide as a camera
// pixel.
typedef struct FfpBeams {
    int width, height;
    real scale; // cells a pattern pixel
    FfpHeard
        *heard; // [height,width], of the four cells whose upper left one it is; depths from the projector
} FfpBeams;

FfpBeams ffp_beams_new(const FfpDepths *depths, int view);
void ffp_beams_free(FfpBeams *beams);

// What is known around the pattern's position (u, v); all 0 outside the grid.
FfpHeard ffp_beams_at(const FfpBeams *beams, real u, real v);

#endif
