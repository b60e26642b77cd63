#include "rig/turntable/axis.h"
#include <math.h>
#include <string.h>
#include "core/base/arena.h"
#include "core/numerics/least_squares.h"
#include "core/numerics/rank.h"

#define STEP 1e-4 // of the numeric derivatives, radians and shares of the distance
#define MOST 0.3  // by which one step moves a number

void ffp_axis_rotate_direction(const FfpAxis *axis, double angle, const double d[3], double out[3]) {
    const double *u = axis->direction, c = cos(angle), s = sin(angle), along = (1 - c) * ffp_dot(u, d);
    double across[3];
    ffp_cross(u, d, across);
    for (int i = 0; i < 3; i++) out[i] = c * d[i] + s * across[i] + along * u[i];
}

void ffp_axis_rotate(const FfpAxis *axis, double angle, const double point[3], double out[3]) {
    double from[3];
    for (int i = 0; i < 3; i++) from[i] = point[i] - axis->point[i];
    ffp_axis_rotate_direction(axis, angle, from, out);
    for (int i = 0; i < 3; i++) out[i] += axis->point[i];
}

void ffp_axis_move(const FfpAxis *from, const double by[FFP_AXIS_NUMBERS], FfpAxis *to) {
    double first[3], second[3], view[3], side[3];
    const double grow = exp(by[FFP_AXIS_DISTANCE]), distance = sqrt(ffp_dot(from->point, from->point));
    ffp_perpendiculars(from->direction, first, second);
    memcpy(view, from->point, sizeof view);
    ffp_cross(from->direction, view, side);
    ffp_unit(side);
    FfpAxis moved;
    for (int i = 0; i < 3; i++) {
        moved.direction[i] = from->direction[i] + by[0] * first[i] + by[1] * second[i];
        moved.point[i] = grow * (from->point[i] + by[FFP_AXIS_SIDEWAYS] * distance * side[i]);
    }
    ffp_unit(moved.direction);
    *to = moved;
}

// --- Least squares. ---

typedef struct Fit {
    const FfpAxisTerm *terms;
    int n_terms, numbers;
    FfpAxis *axis;
} Fit;

static FfpAxis moved(const Fit *fit, const double *by) {
    double held[FFP_AXIS_NUMBERS] = {0};
    FfpAxis out;
    for (int k = 0; k < fit->numbers; k++) held[k] = fmin(fmax(by[k], -MOST), MOST);
    ffp_axis_move(fit->axis, held, &out);
    return out;
}

static void move(void *state, const double *by) {
    const Fit *fit = state;
    *fit->axis = moved(fit, by);
}

// In units of the scales.
static void differences(const void *state, const double *by, double *out) {
    const Fit *fit = state;
    const FfpAxis axis = moved(fit, by);
    for (int t = 0; t < fit->n_terms; t++) {
        const FfpAxisTerm *term = &fit->terms[t];
        term->residuals(term->context, &axis, out);
        for (int i = 0; i < term->count; i++) out[i] /= term->scale;
        out += term->count;
    }
}

// The mean cost, and the weights that make least squares of it: 1 / (1 + r^2)^2.
static double weigh(const void *state, const double *residuals, double *weights) {
    const Fit *fit = state;
    double sum = 0, all = 0;
    for (int t = 0; t < fit->n_terms; t++) {
        const FfpAxisTerm *term = &fit->terms[t];
        for (int i = 0; i < term->count; i++) {
            const double square = residuals[i] * residuals[i];
            const bool there = isfinite(square);
            weights[i] = there ? term->weight / ((1 + square) * (1 + square)) : 0;
            if (term->optional && !there) continue;
            sum += term->weight * (there ? square / (1 + square) : 1);
            all += term->weight;
        }
        residuals += term->count, weights += term->count;
    }
    return all > 0 ? sum / all : 1;
}

double ffp_axis_fit(FfpAxis *axis, int numbers, const FfpAxisTerm *terms, int n_terms, int steps,
                    double *covariance) {
    static const double step[FFP_AXIS_NUMBERS] = {STEP, STEP, STEP, STEP};
    Fit fit = {.terms = terms, .n_terms = n_terms, .numbers = numbers, .axis = axis};
    FfpLeastSquares problem = {.state = &fit,
                               .numbers = numbers,
                               .differences = differences,
                               .move = move,
                               .weigh = weigh,
                               .step = step,
                               .steps = steps,
                               .worth = 1e-7};
    for (int t = 0; t < n_terms; t++) problem.count += terms[t].count;
    return ffp_least_squares(&problem, covariance);
}

double ffp_axis_median(const FfpAxisTerm *term, const FfpAxis *axis, int *there) {
    double *residuals = ffp_alloc((size_t)term->count + 1, sizeof *residuals);
    int n = 0;
    term->residuals(term->context, axis, residuals);
    for (int i = 0; i < term->count; i++)
        if (isfinite(residuals[i])) residuals[n++] = fabs(residuals[i]);
    const double median = n > 0 ? ffp_median(residuals, (size_t)n) : INFINITY;
    if (there) *there = n;
    ffp_free(residuals);
    return median;
}
