// The relation between a capture's pixels and those of its context, from which tokens are made.
#ifndef FFP_NETWORK_CONTEXT_H
#define FFP_NETWORK_CONTEXT_H

#include "engine/network/network.h"

// The position of a capture's pixel among the context's: up to four of them, with weights that sum to 1.
typedef struct FfpTaps {
    int count;
    int64_t pixel[4]; // (view * height + y) * width + x, of the context
    int64_t place[4]; // token * patch^2 + pixel inside the patch
    real weight[4];
} FfpTaps;

typedef struct FfpGrid {
    int width, height;       // of the capture's views
    int patch, across, down; // of the context: tokens across and down a view
    bool same;               // the context's pixels are the capture's
    const real *coverage;    // [views, context height, width] of the context's start; NULL: none
} FfpGrid;

FfpGrid ffp_grid(const FfpModelConfig *config, const FfpCapture *capture, const FfpPixelContext *context);

// Of pixel (view * height + y) * width + x of the capture. Bilinear between the context's pixel centres;
// pixels that the start leaves empty count only where all four are.
FfpTaps ffp_grid_taps(const FfpGrid *grid, int64_t pixel);

#endif
