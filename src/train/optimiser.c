// AdamW with decoupled weight decay (Loshchilov & Hutter 2019), warm-up and cosine, clipping, EMA of the
// weights.
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "base/arena.h"
#include "base/device.h"
#include "base/real.h"
#include "train/kernels/kernels.h"
#include "train/table.h"
#include "train/train.h"

FfpAdam ffp_adam_new(const FfpModel *model) {
    const size_t count = (size_t)model->count;
    FfpAdam adam = {model->count,
                    0,
                    ffp_alloc(count, sizeof(real)),
                    ffp_alloc(count, sizeof(real)),
                    ffp_alloc(count, sizeof(real)),
                    0};
    memcpy(adam.ema, model->values, count * sizeof(real));
    return adam;
}

void ffp_adam_free(FfpAdam *adam) {
    ffp_free(adam->m);
    ffp_free(adam->v);
    ffp_free(adam->ema);
    *adam = (FfpAdam){0};
}

// A new block with a part of `all`, which it replaces.
static void keep(real **all, int64_t first, int64_t count) {
    real *part = ffp_alloc((size_t)count + 1, sizeof(real));
    memcpy(part, *all + first, (size_t)count * sizeof(real));
    ffp_free(*all);
    *all = part;
}

void ffp_adam_keep(FfpAdam *adam, int64_t first, int64_t count) {
    keep(&adam->m, first - adam->first, count);
    keep(&adam->v, first - adam->first, count);
    keep(&adam->ema, first - adam->first, count);
    adam->first = first, adam->count = count;
}

double ffp_learning_rate(const FfpTrainConfig *config, int64_t step) {
    if (step < config->warmup_steps) return config->learning_rate * (double)(step + 1) / config->warmup_steps;
    const double span = (double)(config->steps - config->warmup_steps);
    const double done = span > 0 ? fmin((double)(step - config->warmup_steps) / span, 1.0) : 1.0;
    return config->final_learning_rate +
           0.5 * (config->learning_rate - config->final_learning_rate) * (1 + cos(FFP_PI_DOUBLE * done));
}

// Sum of squares in fixed blocks, added in order: the same bits for any thread count.
static double squared_norm(const real *x, int64_t count) {
    if (ffp_device()) return ffp_device()->train->squared_norm(x, count);
    enum { BLOCK = 1 << 14 };
    const int64_t blocks = (count + BLOCK - 1) / BLOCK;
    double *partial = ffp_alloc((size_t)blocks, sizeof *partial);
#pragma omp parallel for schedule(static)
    for (int64_t b = 0; b < blocks; b++) {
        const int64_t end = (b + 1) * BLOCK < count ? (b + 1) * BLOCK : count;
        double sum = 0;
        for (int64_t i = b * BLOCK; i < end; i++) sum += (double)x[i] * x[i];
        partial[b] = sum;
    }
    double total = 0;
    for (int64_t b = 0; b < blocks; b++) total += partial[b];
    ffp_free(partial);
    return total;
}

static void update_range(const FfpAdamRates *r, real *w, real *m, real *v, real *ema, const real *grad,
                         int64_t count) {
    if (ffp_device()) {
        ffp_device()->train->adam(r, w, m, v, ema, grad, count);
        return;
    }
    ffp_train_kernels()->adam_move(r, w, m, v, ema, grad, count);
}

double ffp_adam_squares(const FfpAdam *adam, const real *grad) {
    return squared_norm(grad + adam->first, adam->count);
}

// The weights of one parameter that the state is of.
static void move_parameter(const FfpAdam *adam, const FfpParameter *parameter, FfpModel *model,
                           const real *grad, const FfpAdamRates *rates) {
    const int64_t end = parameter->offset + parameter->count, own_end = adam->first + adam->count;
    const int64_t from = parameter->offset > adam->first ? parameter->offset : adam->first;
    const int64_t count = (end < own_end ? end : own_end) - from, at = from - adam->first;
    if (count > 0)
        update_range(rates, model->values + from, adam->m + at, adam->v + at, adam->ema + at, grad + from,
                     count);
}

void ffp_adam_move_all(FfpAdam *adam, FfpModel *model, const real *grad, const FfpTrainConfig *config,
                       double norm, bool *skipped) {
    const double rate = ffp_learning_rate(config, adam->step);
    adam->step++;
    *skipped = !isfinite(norm) || norm > config->skip_above * config->clip;
    if (*skipped) return;
    const double t = (double)adam->step;
    FfpAdamRates rates = {
        .beta1 = (real)config->beta1,
        .beta2 = (real)config->beta2,
        .scale = (real)((norm > config->clip ? config->clip / norm : 1.0) / config->batch),
        .step_size = (real)(rate / (1 - pow(config->beta1, t))),
        .correction2 = (real)(1 / (1 - pow(config->beta2, t))),
        // early on the average follows the weights closely: it would otherwise stay at the initial ones
        .ema = (real)fmin(config->ema, t / (t + 10)),
    };
    for (int p = 0; p < model->n_parameters; p++) {
        const FfpParameter *parameter = &model->parameters[p];
        rates.decay = parameter->decay ? (real)(rate * config->weight_decay) : 0;
        move_parameter(adam, parameter, model, grad, &rates);
    }
}

double ffp_adam_update(FfpAdam *adam, FfpModel *model, const real *grad, const FfpTrainConfig *config,
                       bool *skipped) {
    const double norm = sqrt(ffp_adam_squares(adam, grad)) / config->batch;
    ffp_adam_move_all(adam, model, grad, config, norm, skipped);
    return norm;
}
