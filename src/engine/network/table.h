// The work of the network's heads on a device (core/base/device.h): loops over Gaussians and feature maps.
// All arrays are the device's; the blocks before the heads are made of the tensor room's functions alone.
#ifndef FFP_NETWORK_TABLE_H
#define FFP_NETWORK_TABLE_H

#include <stdbool.h>
#include <stdint.h>
#include "core/base/real.h"
#include "core/gaussians/gaussians.h"
#include "engine/network/look.h"
#include "engine/network/splat_formula.h"

// Which rows of a feature map each Gaussian takes, and the reverse.
typedef struct FfpTapTable {
    int taps;       // of each Gaussian
    int64_t rows;   // of the map
    int32_t *row;   // [Gaussians, taps]
    real *weight;   // [Gaussians, taps]
    int32_t *first; // [rows + 1] where a row's takers begin
    int32_t *taker; // [Gaussians * taps] Gaussian * taps + tap, ascending within a row
} FfpTapTable;

typedef struct FfpNetworkTable {
    // out [count, width] = rows `index` of in; and the reverse, which leaves other rows as they are.
    void (*gather_rows)(real *out, const real *in, const int32_t *index, int count, int width);
    void (*scatter_rows)(real *out, const real *in, const int32_t *index, int count, int width);
    // out [count, features + channels] of the Gaussians from `first` on: the mean of the map's rows by
    // weight, and their own inputs, own [Gaussians, channels].
    void (*gather_features)(real *out, const FfpTapTable *taps, int64_t first, int count, const real *map,
                            int features, const real *own, int channels);
    // ADDS to dmap what the Gaussians from `first` on give back, dfeatures [count, features].
    void (*scatter_features)(real *dmap, const FfpTapTable *taps, int64_t first, int count,
                             const real *dfeatures, int features);
    // hidden [count, width] += context_inputs [count, channels] weight [width, channels]^T
    void (*add_context_inputs)(real *hidden, const real *context_inputs, const real *weight, int count,
                               int width, int channels);
    // raw [count, numbers] to Gaussians and distances t; false when a number is not finite.
    bool (*splat)(FfpGaussians *out, real *t, const FfpPixelBase *base, const real *raw, int64_t count,
                  bool residual);
    // draw [count, numbers] of the Gaussians from `first` on; grad_t may be NULL.
    void (*splat_backward)(real *draw, const FfpPixelBase *base, const real *raw, int64_t first, int count,
                           bool residual, const FfpGaussians *grad, const real *grad_t);
    // A drawn view beside its photograph: numbers [pixels, FFP_LOOK_NUMBERS].
    void (*look_compare)(real *numbers, const FfpLookPictures *drawn, const real *colour,
                         const real *coverage, size_t pixels);
    void (*look_gather)(real *out, const FfpLookInputs *looked, int64_t first, int count);
} FfpNetworkTable;

#endif
