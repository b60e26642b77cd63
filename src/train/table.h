// What training does on a device (base/device.h) besides the network, the renderer and the losses: loops over
// weights and over maps. All arrays are the device's.
#ifndef FFP_TRAIN_TABLE_H
#define FFP_TRAIN_TABLE_H

#include <stdint.h>
#include <tgmath.h>
#include "base/real.h"

typedef struct FfpAdamRates { // of one update
    real beta1, beta2, scale, step_size, correction2, decay, ema;
} FfpAdamRates;

// One weight, its moments and its average; AdamW with bias corrections in step_size and correction2.
FFP_FORMULA void ffp_adam_move(const FfpAdamRates *r, real *w, real *m, real *v, real *ema, real grad) {
    const real g = grad * r->scale;
    *m = r->beta1 * *m + (1 - r->beta1) * g;
    *v = r->beta2 * *v + (1 - r->beta2) * g * g;
    *w -= r->step_size * *m / (sqrt(*v * r->correction2) + 1e-8F) + r->decay * *w;
    *ema = r->ema * *ema + (1 - r->ema) * *w;
}

typedef struct FfpTrainTable {
    double (*squared_norm)(const real *x, int64_t count);
    void (*adam)(const FfpAdamRates *rates, real *w, real *m, real *v, real *ema, const real *grad,
                 int64_t count);
    // weight * mean over foreground values (coverage > 0.5) of |sum - opacity truth|, opacity constant; sum,
    // truth [pixels, channels]. ADDS to grad.
    double (*truth_loss)(const real *sum, const real *opacity, const real *truth, const real *coverage,
                         int pixels, int channels, real weight, real *grad);
    // weight * mean over elements of truth > 0 of |t - truth|; OVERWRITES grad [count].
    double (*distance_loss)(const real *t, const real *truth, int64_t count, real weight, real *grad);
} FfpTrainTable;

#endif
