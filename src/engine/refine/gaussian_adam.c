// Adam with a rate for each attribute, a pull back towards the start (adam.h) and smooth displacements, which
// act on the parameters as the pull does.
#include <stdlib.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/base/device.h"
#include "core/base/vec.h"
#include "engine/refine/fit.h"
#include "engine/refine/kernels/kernels.h"
#include "engine/refine/neighbours.h"
#include "engine/refine/table.h"

#define NEIGHBOURS 6

FfpGaussianAdam ffp_gaussian_adam_new(const FfpParameters *parameters, const FfpRefineSettings *settings) {
    const int64_t count = parameters->numbers.count;
    bool pulls = false;
    for (int a = 0; a < FFP_ATTRIBUTES; a++) pulls = pulls || settings->rates.pull[a] > 0;
    FfpGaussianAdam adam_state = {.mean = ffp_gaussians_new(count),
                                  .square = ffp_gaussians_new(count),
                                  .shared = ffp_memory_new(FFP_SHARED_NUMBERS, sizeof(real))};
    adam_state.start = ffp_gaussians_new(pulls ? count : 0);
    if (settings->coupled && !settings->growth)
        adam_state.cross = ffp_memory_new((size_t)count + 1, 3 * sizeof(real));
    for (int a = 0; pulls && a < FFP_ATTRIBUTES; a++) {
        const FfpAttribute from = ffp_attribute(&parameters->numbers, a);
        ffp_memory_copy(ffp_attribute(&adam_state.start, a).data, from.data,
                        (size_t)count * (size_t)from.width * sizeof(real));
    }
    if (settings->smooth > 0) {
        adam_state.neighbour = ffp_alloc((size_t)count + 1, NEIGHBOURS * sizeof *adam_state.neighbour);
        ffp_neighbours(parameters->origin, count, NEIGHBOURS, adam_state.neighbour, NULL);
    }
    return adam_state;
}

void ffp_gaussian_adam_free(FfpGaussianAdam *adam_state) {
    ffp_gaussians_free(&adam_state->mean);
    ffp_gaussians_free(&adam_state->square);
    ffp_gaussians_free(&adam_state->start);
    ffp_memory_free(adam_state->cross);
    ffp_memory_free(adam_state->shared);
    ffp_free(adam_state->neighbour);
    *adam_state = (FfpGaussianAdam){0};
}

static void displacement(const FfpParameters *p, int64_t i, real out[3]) {
    real m[9];
    ffp_quaternion_matrix(p->frame + 4 * i, m);
    for (int k = 0; k < 3; k++) out[k] = p->unit[i] * ffp_dot3(m + 3 * k, p->numbers.centre + 3 * i);
}

// Along its third axis each centre goes `share` of the way to the mean displacement of its neighbours.
static void smooth_displacements(const FfpGaussianAdam *adam_state, FfpParameters *p, real share) {
    const int64_t count = p->numbers.count;
    real *moved = ffp_alloc((size_t)count + 1, 3 * sizeof(real));
#pragma omp parallel for schedule(static)
    for (int64_t i = 0; i < count; i++) displacement(p, i, moved + 3 * i);
#pragma omp parallel for schedule(static)
    for (int64_t i = 0; i < count; i++) {
        real m[9], sum[3] = {0};
        int found = 0;
        for (int j = 0; j < NEIGHBOURS; j++) {
            const int64_t other = adam_state->neighbour[i * NEIGHBOURS + j];
            if (other < 0) continue;
            for (int k = 0; k < 3; k++) sum[k] += moved[3 * other + k];
            found++;
        }
        if (!found) continue;
        ffp_quaternion_matrix(p->frame + 4 * i, m);
        const real along = (m[2] * sum[0] + m[5] * sum[1] + m[8] * sum[2]) / ((real)found * p->unit[i]);
        p->numbers.centre[3 * i + 2] += share * (along - p->numbers.centre[3 * i + 2]);
    }
    ffp_free(moved);
}

static double decay_of(const FfpRefineSettings *settings, int attribute, int64_t step, double share) {
    if (attribute != FFP_CENTRE) return pow(settings->decay, share);
    if (settings->centre_decay_steps > 0)
        share = fmin((double)step / (double)settings->centre_decay_steps, 1);
    return pow(settings->centre_decay, share);
}

static FfpAdamStep step_of(const FfpRefineSettings *settings, int64_t step, double rate, double pull) {
    FfpAdamStep out = ffp_adam_step(rate, (double)settings->beta1, (double)settings->beta2,
                                    (double)settings->epsilon, step);
    out.pull = (real)(rate * pull);
    return out;
}

static FfpGaussianAdamStep move_of(const FfpRefineSettings *settings, int64_t step, double share) {
    const FfpRates *rates = &settings->rates;
    FfpGaussianAdamStep move = {.shares = rates->shared_roughness > 0};
    for (int a = 0; a < FFP_ATTRIBUTES; a++) {
        const double rate = rates->rate[a] * decay_of(settings, a, step, share);
        move.of[a] = step_of(settings, step, rate, rates->pull[a]);
    }
    const double rate = rates->shared_roughness * decay_of(settings, FFP_ROUGHNESS, step, share);
    move.shared = step_of(settings, step, rate, 0);
    return move;
}

// A highlight is in few pixels of few views: a splat's own roughness hardly learns from it. So each logit is
// r_i = s + d_i, with dL/ds = sum_i dL/dr_i, and s has an Adam of its own. The d_i are moved and pulled back
// elsewhere: what they are pulled towards goes along with s.
static void move_shared_roughness(FfpGaussianAdam *adam_state, FfpParameters *parameters,
                                  const FfpGaussians *grad, const FfpAdamStep *step) {
    double sum = 0;
    for (int64_t i = 0; i < grad->count; i++) sum += (double)grad->roughness[i];
    ffp_adam_shared(step, sum, adam_state->shared);
    const real moved = adam_state->shared[FFP_SHARED_MOVED];
    for (int64_t i = 0; i < grad->count; i++) parameters->numbers.roughness[i] += moved;
    for (int64_t i = 0; i < adam_state->start.count; i++) adam_state->start.roughness[i] += moved;
}

static void move_centres(const FfpGaussianAdam *adam_state, const FfpAdamArray *centres) {
    enum { PART = 512 }; // splats
    FfpMoveCoupled *move = ffp_refine_kernels()->move_coupled;
    const int64_t count = centres->count / 3;
#pragma omp parallel for schedule(static)
    for (int64_t i = 0; i < count; i += PART)
        move(centres, adam_state->cross, i, count - i < PART ? count - i : PART);
}

static void move_all(FfpGaussianAdam *adam_state, FfpParameters *parameters, const FfpGaussians *grad,
                     const FfpGaussianAdamStep *move) {
    FfpAdamArray arrays[FFP_ATTRIBUTES];
    for (int a = 0; a < FFP_ATTRIBUTES; a++) {
        const FfpAttribute x = ffp_attribute(&parameters->numbers, a);
        arrays[a] = (FfpAdamArray){
            .step = move->of[a],
            .count = grad->count * x.width,
            .x = x.data,
            .mean = ffp_attribute(&adam_state->mean, a).data,
            .square = ffp_attribute(&adam_state->square, a).data,
            .grad = ffp_attribute(grad, a).data,
            .start = adam_state->start.count ? ffp_attribute(&adam_state->start, a).data : NULL};
    }
    if (adam_state->cross) {
        move_centres(adam_state, &arrays[FFP_CENTRE]);
        arrays[FFP_CENTRE].count = 0;
    }
    ffp_adam(arrays, FFP_ATTRIBUTES);
    if (move->shares) move_shared_roughness(adam_state, parameters, grad, &move->shared);
}

void ffp_gaussian_adam_step(FfpGaussianAdam *adam_state, FfpParameters *parameters, const FfpGaussians *grad,
                            const FfpRefineSettings *settings, double share) {
    adam_state->step++;
    const FfpGaussianAdamStep move = move_of(settings, adam_state->step, share);
    if (ffp_device())
        ffp_device()->refine->move(&move, grad, &parameters->numbers, adam_state);
    else
        move_all(adam_state, parameters, grad, &move);
    if (adam_state->neighbour) smooth_displacements(adam_state, parameters, settings->smooth);
}
