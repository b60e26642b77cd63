// Deferred values (loss.h), for the other sources of this room.
#ifndef FFP_LOSS_DEFERRED_H
#define FFP_LOSS_DEFERRED_H

#include <stdbool.h>
#include "core/base/real.h"

typedef enum FfpDeferredKind {
    FFP_DEFERRED_PLAIN,      // the device's value v as it is
    FFP_DEFERRED_SIMILARITY, // scale (1 - v)
    FFP_DEFERRED_PSNR,       // of the mean squared error v
} FfpDeferredKind;

// Sets the meaning of the value that the device kept last; false if values are not deferred.
bool ffp_loss_deferred_as(FfpDeferredKind kind, real scale);
// PSNR in dB of a mean squared error, up to the cap.
double ffp_psnr_of(double mean_square);

#endif
