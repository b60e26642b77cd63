// Averages of a pattern over axis-aligned boxes, from a summed-area table (Crow 1984), and the gradients of
// it.
#ifndef FFP_IMAGE_LOOKUP_H
#define FFP_IMAGE_LOOKUP_H

#include <stdbool.h>
#include "core/image/image.h"

enum { FFP_SUMMED_CHANNELS = 4 }; // the last is 0: an entry is one vector

// Summed areas in double: an 800x800 sum in fp32 would lose the last bits that differences need.
typedef struct FfpSummed {
    int width, height;
    double *sum; // [height+1, width+1, FFP_SUMMED_CHANNELS]; NULL where
    bool plain;  // one colour is everywhere, as in white: its boxes need no table
    double colour[3];
} FfpSummed;

FfpSummed ffp_summed_new(const FfpImage *rgb); // 3 channels; on the CPU only
void ffp_summed_fill(FfpSummed *summed,
                     const FfpImage *rgb);         // the same into an existing table, or an empty one
FfpSummed ffp_summed_zeros(int width, int height); // for ffp_lookup_backward_pattern
// A copy of the CPU's table on the device that the thread works on (core/base/device.h).
FfpSummed ffp_summed_uploaded(const FfpSummed *host);
void ffp_summed_free(FfpSummed *summed); // by who works on the device it came from

// Mean colour of the pattern (constant within a pixel, black outside) over the box centred at (u,v) of size
// (du,dv) pixels, each at least 1. At du = dv = 1 this is bilinear interpolation.
void ffp_lookup(const FfpSummed *summed, real u, real v, real du, real dv, real out[3]);
// Adjoint with respect to the pattern: scatters into grad_sum (ffp_summed_zeros); when all pixels
// are done, ffp_lookup_gather_pattern turns it into the gradient image [height,width,3].
void ffp_lookup_backward_pattern(FfpSummed *grad_sum, real u, real v, real du, real dv, const real grad[3]);
void ffp_lookup_gather_pattern(const FfpSummed *grad_sum, FfpImage *grad_pattern);

#endif
