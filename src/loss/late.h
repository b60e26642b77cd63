// Values that are taken late (loss.h), for the other sources of this room.
#ifndef FFP_LOSS_LATE_H
#define FFP_LOSS_LATE_H

#include <stdbool.h>
#include "base/real.h"

typedef enum FfpLateKind {
    FFP_LATE_PLAIN,      // the device's value v as it is
    FFP_LATE_SIMILARITY, // scale (1 - v)
    FFP_LATE_PSNR,       // of the mean squared error v
} FfpLateKind;

// What the value that the device kept last stands for; false when values are not taken late.
bool ffp_late_as(FfpLateKind kind, real scale);
// PSNR in dB of a mean squared error, up to the cap.
double ffp_psnr_of(double mean_square);

#endif
