// The functions that a device provides for a fit (core/base/device.h): all work on arrays except drawing and
// losses. Structs are the host's, their arrays the device's; nothing here waits for the device.
#ifndef FFP_REFINE_TABLE_H
#define FFP_REFINE_TABLE_H

#include "core/image/lookup.h"
#include "engine/refine/adam.h"
#include "engine/refine/parameters.h"

typedef struct FfpRefineTable {
    void (*clear)(const FfpGaussians *gaussians); // all numbers 0
    // The maps of parameters.h; encode fills all arrays of `out`.
    void (*encode)(const FfpGaussians *gaussians, bool local, const FfpParameters *out);
    void (*decode)(const FfpParameters *parameters, const FfpGaussians *out);
    void (*pull_back)(const FfpParameters *parameters, const FfpGaussians *decoded, const FfpGaussians *grad);
    void (*average)(const FfpGaussians *numbers, real share, const FfpGaussians *mean); // ffp_average, of all
    // One step of all numbers, the shared roughness included. The same bits every time.
    void (*move)(const FfpGaussianAdamStep *move, const FfpGaussians *grad, const FfpGaussians *numbers,
                 const FfpGaussianAdam *adam_state);
    // As ffp_summed_new, in double too; sums of a row are taken in another order (last bits differ).
    FfpSummed (*summed_new)(const FfpImage *rgb);
} FfpRefineTable;

#endif
