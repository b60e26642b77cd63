// This room's functions on a device (core/base/device.h). All arrays are in the device's memory; only the
// values returned are not. loss.h describes the functions.
#ifndef FFP_LOSS_TABLE_H
#define FFP_LOSS_TABLE_H

#include <stdbool.h>
#include <stddef.h>
#include "core/image/image.h"
#include "engine/loss/loss.h"

enum { FFP_DEFERRED_MAX = 1024 };

struct FfpLossTable {
    real (*l1)(const FfpImage *prediction, const FfpImage *target, real weight, FfpImage *grad);
    real (*square)(const FfpImage *prediction, const FfpImage *target, real weight, FfpImage *grad);
    // The mean of the index; ADDS scale * gradient of the SUM of the index by a to grad unless that is NULL.
    double (*ssim)(const FfpImage *a, const FfpImage *b, real scale, FfpImage *grad);
    real (*mask)(const real *opacity, const real *mask, int pixels, real weight, real *grad_opacity);
    real (*depth)(const real *depth_sum, const real *opacity, const real *truth, int pixels, real weight,
                  real *grad_depth_sum, real *grad_opacity);
    real (*distortion)(const real *distortion, int pixels, real weight, real *grad_distortion);
    double (*truth)(const real *sum, const real *opacity, const FfpImage *truth, const FfpImage *coverage,
                    real weight, real *grad);
    double (*distance)(const real *t, const real *truth, int64_t count, real weight, real *grad);
    real (*normal_smooth)(const real *normal_sum, const real *mask, int width, int height, real weight,
                          real *grad);
    real (*roughness)(const real *roughness_sum, const real *albedo_sum, const real *opacity,
                      const real *mask, int width, int height, real weight, real *grad_roughness_sum,
                      real *grad_opacity);
    // Sum of the squared differences over the pixels whose mask is above 0.5 (NULL: all); *count receives the
    // number of these values.
    double (*squared_error)(const FfpImage *a, const FfpImage *b, const FfpImage *mask, size_t *count);
    // While it is on, values are kept on the device, up to FFP_DEFERRED_MAX of them, and 0 is returned:
    // squared_error without a mask keeps the mean, the others what they would have returned.
    void (*late)(bool on);
    int (*deferred_count)(void); // how many are kept
    void (*deferred_values)(
        double *values); // in the order in which they were computed; waits, and clears them
    // A perceptual network's weights on the device, and the loss with them; the pictures are large enough.
    void *(*perceptual_upload)(const FfpPerceptual *perceptual);
    void (*perceptual_release)(void *weights);
    real (*perceptual)(const FfpPerceptual *perceptual, const void *weights, const FfpImage *prediction,
                       const FfpImage *target, real weight, FfpImage *grad);
};

#endif
