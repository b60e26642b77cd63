// Pixel losses: mean absolute and squared differences, and the way back through the sRGB transfer function.
#include <assert.h>
#include <tgmath.h>
#include "core/base/device.h"
#include "engine/loss/loss.h"
#include "engine/loss/rows.h"
#include "engine/loss/table.h"
#include "engine/loss/terms.h"

typedef struct Difference { // of two pictures
    const real *prediction, *target;
    real *grad; // NULL: not wanted
    real step;
    size_t row; // numbers in one
} Difference;

// Row by row in real, rows in double: a picture's sum in fp32 would lose digits.
static double l1_row(const void *argument, int y) {
    const Difference *d = argument;
    const real *p = d->prediction + y * d->row, *t = d->target + y * d->row, step = d->step;
    real sum = 0;
#pragma omp simd reduction(+ : sum)
    for (size_t i = 0; i < d->row; i++) sum += fabs(p[i] - t[i]);
    if (!d->grad) return sum;
    real *g = d->grad + y * d->row;
    for (size_t i = 0; i < d->row; i++) g[i] += ffp_signed(step, p[i] - t[i]);
    return sum;
}

static double square_row(const void *argument, int y) {
    const Difference *d = argument;
    const real *p = d->prediction + y * d->row, *t = d->target + y * d->row, step = d->step;
    real sum = 0;
#pragma omp simd reduction(+ : sum)
    for (size_t i = 0; i < d->row; i++) sum += (p[i] - t[i]) * (p[i] - t[i]);
    if (!d->grad) return sum;
    real *g = d->grad + y * d->row;
    for (size_t i = 0; i < d->row; i++) g[i] += step * (p[i] - t[i]);
    return sum;
}

// weight * the mean over all numbers of what `of_row` adds up; slope: of one number's term, without the
// weight.
static real mean_of(FfpRowSum *of_row, const FfpImage *prediction, const FfpImage *target, real weight,
                    real slope, FfpImage *grad) {
    const size_t row = (size_t)prediction->width * prediction->channels, count = row * prediction->height;
    const Difference d = {prediction->data, target->data, grad ? grad->data : NULL,
                          slope * weight / (real)count, row};
    return weight * (real)(ffp_sum_of_rows(prediction->height, of_row, &d) / (double)count);
}

// True if there is nothing to compare.
static bool are_empty(const FfpImage *a, const FfpImage *b) {
    assert(a->width == b->width && a->height == b->height && a->channels == b->channels);
    return (size_t)a->width * a->height * b->channels == 0;
}

real ffp_l1_loss(const FfpImage *prediction, const FfpImage *target, real weight, FfpImage *grad) {
    if (are_empty(prediction, target)) return 0;
    if (ffp_device()) return ffp_device()->loss->l1(prediction, target, weight, grad);
    return mean_of(l1_row, prediction, target, weight, 1, grad);
}

real ffp_square_loss(const FfpImage *prediction, const FfpImage *target, real weight, FfpImage *grad) {
    if (are_empty(prediction, target)) return 0;
    if (ffp_device()) return ffp_device()->loss->square(prediction, target, weight, grad);
    return mean_of(square_row, prediction, target, weight, 2, grad);
}
