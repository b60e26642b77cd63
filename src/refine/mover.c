// Adam with a rate for each attribute, a pull back towards the start (adam.h) and smooth displacements, which
// act on the parameters as the pull does.
#include <stdlib.h>
#include <string.h>
#include "base/arena.h"
#include "base/device.h"
#include "base/vec.h"
#include "refine/fit.h"
#include "refine/kernels/kernels.h"
#include "refine/neighbours.h"
#include "refine/table.h"

#define NEIGHBOURS 6

FfpMover ffp_mover_new(const FfpParameters *parameters, const FfpRefineSettings *settings) {
    const int64_t count = parameters->numbers.count;
    bool pulls = false;
    for (int a = 0; a < FFP_ATTRIBUTES; a++) pulls = pulls || settings->rates.pull[a] > 0;
    FfpMover mover = {.mean = ffp_gaussians_new(count),
                      .square = ffp_gaussians_new(count),
                      .shared = ffp_memory_new(FFP_SHARED_NUMBERS, sizeof(real))};
    mover.start = ffp_gaussians_new(pulls ? count : 0);
    for (int a = 0; pulls && a < FFP_ATTRIBUTES; a++) {
        const FfpAttribute from = ffp_attribute(&parameters->numbers, a);
        ffp_memory_copy(ffp_attribute(&mover.start, a).data, from.data,
                        (size_t)count * (size_t)from.width * sizeof(real));
    }
    if (settings->smooth > 0) {
        mover.neighbour = ffp_alloc((size_t)count + 1, NEIGHBOURS * sizeof *mover.neighbour);
        ffp_neighbours(parameters->origin, count, NEIGHBOURS, mover.neighbour, NULL);
    }
    return mover;
}

void ffp_mover_free(FfpMover *mover) {
    ffp_gaussians_free(&mover->mean);
    ffp_gaussians_free(&mover->square);
    ffp_gaussians_free(&mover->start);
    ffp_memory_free(mover->shared);
    ffp_free(mover->neighbour);
    *mover = (FfpMover){0};
}

static void displacement(const FfpParameters *p, int64_t i, real out[3]) {
    real m[9];
    ffp_quaternion_matrix(p->frame + 4 * i, m);
    for (int k = 0; k < 3; k++) out[k] = p->unit[i] * ffp_dot3(m + 3 * k, p->numbers.centre + 3 * i);
}

// Along its third axis each centre goes `share` of the way to the mean displacement of its neighbours.
static void smooth_displacements(const FfpMover *mover, FfpParameters *p, real share) {
    const int64_t count = p->numbers.count;
    real *moved = ffp_alloc((size_t)count + 1, 3 * sizeof(real));
#pragma omp parallel for schedule(static)
    for (int64_t i = 0; i < count; i++) displacement(p, i, moved + 3 * i);
#pragma omp parallel for schedule(static)
    for (int64_t i = 0; i < count; i++) {
        real m[9], sum[3] = {0};
        int found = 0;
        for (int j = 0; j < NEIGHBOURS; j++) {
            const int64_t other = mover->neighbour[i * NEIGHBOURS + j];
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

static FfpUpdate update_of(const FfpRefineSettings *settings, int64_t step, double rate, double pull) {
    const double t = (double)step;
    return (FfpUpdate){.rate = (real)rate,
                       .pull = (real)(rate * pull),
                       .beta1 = settings->beta1,
                       .beta2 = settings->beta2,
                       .correction1 = (real)(1 / (1 - pow((double)settings->beta1, t))),
                       .correction2 = (real)(1 / (1 - pow((double)settings->beta2, t))),
                       .epsilon = settings->epsilon};
}

static FfpMove move_of(const FfpRefineSettings *settings, int64_t step, double share) {
    const FfpRates *rates = &settings->rates;
    FfpMove move = {.shares = rates->shared_roughness > 0};
    for (int a = 0; a < FFP_ATTRIBUTES; a++) {
        const double rate = rates->rate[a] * decay_of(settings, a, step, share);
        move.of[a] = update_of(settings, step, rate, rates->pull[a]);
    }
    const double rate = rates->shared_roughness * decay_of(settings, FFP_ROUGHNESS, step, share);
    move.shared = update_of(settings, step, rate, 0);
    return move;
}

// A highlight is in few pixels of few views: a splat's own roughness hardly learns from it. So each logit is
// r_i = s + d_i, with dL/ds = sum_i dL/dr_i, and s has an Adam of its own. The d_i are moved and pulled back
// elsewhere: what they are pulled towards goes along with s.
static void move_shared_roughness(FfpMover *mover, FfpParameters *parameters, const FfpGaussians *grad,
                                  const FfpUpdate *u) {
    double sum = 0;
    for (int64_t i = 0; i < grad->count; i++) sum += (double)grad->roughness[i];
    ffp_adam_shared(u, sum, mover->shared);
    const real moved = mover->shared[FFP_SHARED_MOVED];
    for (int64_t i = 0; i < grad->count; i++) parameters->numbers.roughness[i] += moved;
    for (int64_t i = 0; i < mover->start.count; i++) mover->start.roughness[i] += moved;
}

static void move_all(FfpMover *mover, FfpParameters *parameters, const FfpGaussians *grad,
                     const FfpMove *move) {
    FfpAdamStep *adam = ffp_refine_kernels()->adam_step;
#pragma omp parallel
    for (int a = 0; a < FFP_ATTRIBUTES; a++) {
        const FfpAttribute x = ffp_attribute(&parameters->numbers, a);
        adam(&move->of[a], x.data, ffp_attribute(&mover->mean, a).data, ffp_attribute(&mover->square, a).data,
             ffp_attribute(grad, a).data, mover->start.count ? ffp_attribute(&mover->start, a).data : NULL,
             grad->count * x.width);
    }
    if (move->shares) move_shared_roughness(mover, parameters, grad, &move->shared);
}

void ffp_mover_step(FfpMover *mover, FfpParameters *parameters, const FfpGaussians *grad,
                    const FfpRefineSettings *settings, double share) {
    mover->step++;
    const FfpMove move = move_of(settings, mover->step, share);
    if (ffp_device())
        ffp_device()->refine->move(&move, grad, &parameters->numbers, mover);
    else
        move_all(mover, parameters, grad, &move);
    if (mover->neighbour) smooth_displacements(mover, parameters, settings->smooth);
}
