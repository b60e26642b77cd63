// AdamW with decoupled weight decay (Loshchilov & Hutter 2019), warm-up and cosine, clipping, EMA of the
// weights.
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/real.h"
#include "core/tensor/adam.h"
#include "lab/train/train.h"

FfpAdam ffp_adam_new(const FfpModel *model) {
    const size_t count = (size_t)model->count;
    FfpAdam adam = {model->count,
                    0,
                    ffp_alloc(count, sizeof(real)),
                    ffp_alloc(count, sizeof(real)),
                    ffp_alloc(count, sizeof(real)),
                    0,
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
    adam->first = first;
    adam->count = count;
}

double ffp_learning_rate(const FfpTrainConfig *config, int64_t step) {
    if (step < config->warmup_steps) return config->learning_rate * (double)(step + 1) / config->warmup_steps;
    const double span = (double)(config->steps - config->warmup_steps);
    const double done = span > 0 ? fmin((double)(step - config->warmup_steps) / span, 1.0) : 1.0;
    return config->final_learning_rate +
           0.5 * (config->learning_rate - config->final_learning_rate) * (1 + cos(FFP_PI_DOUBLE * done));
}

static int64_t larger(int64_t a, int64_t b) {
    return a > b ? a : b;
}

double ffp_adam_squares(const FfpAdam *adam, const real *grad) {
    const int64_t from = larger(adam->first, adam->learning), end = adam->first + adam->count;
    return ffp_squared_norm(grad + from, larger(end - from, 0));
}

// The weights of one parameter that the state is of and that learn.
static void move_parameter(const FfpAdam *adam, const FfpParameter *parameter, FfpModel *model,
                           const real *grad, const FfpAdamStep *step) {
    const int64_t end = parameter->offset + parameter->count, own_end = adam->first + adam->count;
    const int64_t from = larger(parameter->offset, larger(adam->first, adam->learning));
    const FfpAdamArray array = {.step = *step,
                                .count = (end < own_end ? end : own_end) - from,
                                .x = model->values + from,
                                .mean = adam->m + (from - adam->first),
                                .square = adam->v + (from - adam->first),
                                .average = adam->ema + (from - adam->first),
                                .grad = grad + from};
    if (array.count > 0) ffp_adam(&array, 1);
}

void ffp_adam_move_all(FfpAdam *adam, FfpModel *model, const real *grad, const FfpTrainConfig *config,
                       double norm, bool *skipped) {
    const double rate = ffp_learning_rate(config, adam->step);
    adam->step++;
    *skipped = !isfinite(norm) || norm > config->skip_above * config->clip;
    if (*skipped) return;
    const double t = (double)adam->step;
    FfpAdamStep step = ffp_adam_step(rate, config->beta1, config->beta2, 1e-8, adam->step);
    step.rate = (real)(rate / (1 - pow(config->beta1, t))); // the correction is in the rate
    step.correction1 = 1;
    step.scale = (real)((norm > config->clip ? config->clip / norm : 1.0) / config->batch);
    // early on the average follows the weights closely: it would otherwise stay at the initial ones
    step.average = (real)fmin(config->ema, t / (t + 10));
    for (int p = 0; p < model->n_parameters; p++) {
        const FfpParameter *parameter = &model->parameters[p];
        step.decay = parameter->decay ? (real)(rate * config->weight_decay) : 0;
        move_parameter(adam, parameter, model, grad, &step);
    }
}

double ffp_adam_update(FfpAdam *adam, FfpModel *model, const real *grad, const FfpTrainConfig *config,
                       bool *skipped) {
    const double norm = sqrt(ffp_adam_squares(adam, grad)) / config->batch;
    ffp_adam_move_all(adam, model, grad, config, norm, skipped);
    return norm;
}
