// The projector's light observed by one view: each pattern's colour at each pixel, independent of the albedo.
#ifndef FFP_MATCH_OBSERVE_H
#define FFP_MATCH_OBSERVE_H

#include "core/base/real.h"
#include "core/capture/capture.h"

typedef struct FfpObservation {
    int width, height;
    int count;    // of the patterns asked for, those that the view was photographed under
    int *asked;   // [count] which of those asked for
    real *ratio;  // [count,h,w,3] (photograph - black) / (white - black): the pattern's linear colour there,
                  // in [0,1.2]
    real *weight; // [h,w,3] (white - black) against the view's mean over the object, times coverage, in
                  // [0,1]; 0 off the object
    real *lit;    // [h,w] mean of the three weights
} FfpObservation;

// patterns [n]: indices into the capture's. The view has black and white.
FfpObservation ffp_observe(const FfpCapture *capture, int view, const int *patterns, int n);
void ffp_observation_free(FfpObservation *observation);

// Patterns averaged over boxes of one size, on a grid no finer than that needs: cheap to sample at many
// hypotheses. The grid has a border of one repeated cell, and a cell four numbers, of which the last is 0: a
// sample is four vector loads. All patterns have the grid's size, so that a position is found once for all.
typedef struct FfpBlurred {
    int stride; // cells per row, including the border
    int patterns;
    size_t area;        // cells of a pattern
    real *cells;        // [patterns,.,stride,4]
    real scale;         // grid cells per pattern pixel
    real width, height; // of a pattern, pixels
} FfpBlurred;
// patterns [n]: indices into the capture's.
FfpBlurred ffp_blurred_new(const FfpCapture *capture, const int *patterns, int n, real box);
void ffp_blurred_free(FfpBlurred *blurred);

// Pattern pixels that a camera pixel of this view covers at the object's centre, seen at a middling slant; at
// least 1.
real ffp_typical_footprint(const FfpCapture *capture, int view);

#endif
