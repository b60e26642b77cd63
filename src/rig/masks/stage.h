// The stage: what camera and projector see where the object is taken away, and what of a view is like it.
#ifndef FFP_RIG_STAGE_H
#define FFP_RIG_STAGE_H

#include "core/capture/capture.h"

typedef struct FfpEmptyStage {
    FfpImage *images; // [n_patterns] as FfpView.images, without the object; .data NULL: not photographed
    FfpImage known;   // 1 channel, above 0 where the stage is known, below where all views show the object;
                      // .data NULL: known everywhere
} FfpEmptyStage;

// What a pixel of a view is, as far as it can be told from the stage alone.
typedef enum FfpPixelKind {
    FFP_PIXEL_UNKNOWN,   // in shadow, or neither like the stage nor clearly another thing
    FFP_PIXEL_STAGE,     // lit, and as the stage is under every pattern
    FFP_PIXEL_DIM_STAGE, // like the stage, but so little light says less
    FFP_PIXEL_OBJECT,    // lit, and unlike the stage
    FFP_PIXEL_LIT,       // lit where the stage is not known
} FfpPixelKind;

typedef struct FfpCompared {
    unsigned char *kinds; // [height*width] FfpPixelKind, owned
    double noise;         // linear: what two smoothed pictures of one thing differ by
    double gain;          // of the view over the stage, from what is lit
    double stage;         // share of the pixels that the camera saw which are stage, dim or not
} FfpCompared;

// Compares a view's photographs, which are not masked yet, with the stage's, both smoothed. With the light d
// that each pattern adds to black in the view and d0 on the stage, a pixel is stage where one factor near 1
// explains all patterns and channels, d = a d0; a shadow and what it leaves half lit have smaller factors and
// are unknown. Errors allowed are those of the noise, of 6 % of the light, and of a pixel's neighbours, since
// lens and pixel blur edges. `where` names the view's pictures in errors: of the stage hardly anything is
// seen.
bool ffp_stage_compare(FfpCompared *compared, const FfpCapture *capture, int view, const FfpEmptyStage *stage,
                       const char *where, FfpError *err);

#endif
