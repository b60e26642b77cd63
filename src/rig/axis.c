#include "rig/axis.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/arena.h"
#include "base/call.h"

#define STEP 1e-4 // of the numeric derivatives, radians and shares of the distance

void ffp_axis_turn_direction(const FfpAxis *axis, double angle, const double d[3], double out[3]) {
    const double *u = axis->direction, c = cos(angle), s = sin(angle), along = (1 - c) * ffp_dot(u, d);
    double across[3];
    ffp_cross(u, d, across);
    for (int i = 0; i < 3; i++) out[i] = c * d[i] + s * across[i] + along * u[i];
}

void ffp_axis_turn(const FfpAxis *axis, double angle, const double point[3], double out[3]) {
    double from[3];
    for (int i = 0; i < 3; i++) from[i] = point[i] - axis->point[i];
    ffp_axis_turn_direction(axis, angle, from, out);
    for (int i = 0; i < 3; i++) out[i] += axis->point[i];
}

void ffp_axis_move(const FfpAxis *from, const double by[FFP_AXIS_NUMBERS], FfpAxis *to) {
    double first[3], second[3], view[3], side[3];
    const double grow = exp(by[FFP_AXIS_DISTANCE]), distance = sqrt(ffp_dot(from->point, from->point));
    ffp_across(from->direction, first, second);
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
    int n_terms, numbers, count;
    double *here, *there, *slopes; // [count], [count], [numbers, count]; in units of the scales
} Fit;

static void evaluate(const Fit *fit, const FfpAxis *axis, double *out) {
    for (int t = 0; t < fit->n_terms; t++) {
        const FfpAxisTerm *term = &fit->terms[t];
        term->residuals(term->context, axis, out);
        for (int i = 0; i < term->count; i++) out[i] /= term->scale;
        out += term->count;
    }
}

static double mean_cost(const Fit *fit, const double *residuals) {
    double sum = 0, weights = 0;
    for (int t = 0; t < fit->n_terms; t++) {
        const FfpAxisTerm *term = &fit->terms[t];
        for (int i = 0; i < term->count; i++) {
            const double square = residuals[i] * residuals[i];
            if (term->optional && !isfinite(square)) continue;
            sum += term->weight * (isfinite(square) ? square / (1 + square) : 1);
            weights += term->weight;
        }
        residuals += term->count;
    }
    return weights > 0 ? sum / weights : 1;
}

// Central differences; 0 where either side has no residual.
static void differentiate(const Fit *fit, const FfpAxis *axis) {
    for (int k = 0; k < fit->numbers; k++) {
        double by[FFP_AXIS_NUMBERS] = {0}, *slope = fit->slopes + (size_t)k * (size_t)fit->count;
        FfpAxis moved;
        by[k] = STEP;
        ffp_axis_move(axis, by, &moved);
        evaluate(fit, &moved, slope);
        by[k] = -STEP;
        ffp_axis_move(axis, by, &moved);
        evaluate(fit, &moved, fit->there);
        for (int i = 0; i < fit->count; i++) {
            const double difference = (slope[i] - fit->there[i]) / (2 * STEP);
            slope[i] = isfinite(difference) ? difference : 0;
        }
    }
}

// Normal equations with the weights that make least squares of the robust cost: 1 / (1 + r^2)^2.
static void gather(const Fit *fit, double matrix[16], double vector[4]) {
    memset(matrix, 0, 16 * sizeof *matrix);
    memset(vector, 0, 4 * sizeof *vector);
    int i = 0;
    for (int t = 0; t < fit->n_terms; t++) {
        for (int n = 0; n < fit->terms[t].count; n++, i++) {
            const double r = fit->here[i], square = 1 + r * r;
            if (!isfinite(square)) continue;
            const double weight = fit->terms[t].weight / (square * square);
            for (int k = 0; k < fit->numbers; k++) {
                const double slope = weight * fit->slopes[(size_t)k * (size_t)fit->count + (size_t)i];
                vector[k] -= slope * r;
                for (int m = 0; m <= k; m++)
                    matrix[4 * k + m] += slope * fit->slopes[(size_t)m * (size_t)fit->count + (size_t)i];
            }
        }
    }
    for (int k = 0; k < 4; k++)
        for (int m = k + 1; m < 4; m++) matrix[4 * k + m] = matrix[4 * m + k];
}

// Gauss and Jordan with pivots, n up to 4: solves matrix x = columns for m columns in place; false when
// singular.
static bool solve(int n, double *matrix, int m, double *columns) {
    for (int k = 0; k < n; k++) {
        int pivot = k;
        for (int i = k + 1; i < n; i++)
            if (fabs(matrix[4 * i + k]) > fabs(matrix[4 * pivot + k])) pivot = i;
        if (!(fabs(matrix[4 * pivot + k]) > 1e-300)) return false;
        for (int j = 0; j < n + m; j++) {
            double *row = j < n ? matrix + j : columns + (j - n), kept = row[4 * k];
            row[4 * k] = row[4 * pivot], row[4 * pivot] = kept;
        }
        for (int i = 0; i < n; i++) {
            const double factor = i == k ? 0 : matrix[4 * i + k] / matrix[4 * k + k];
            for (int j = 0; j < n + m && factor != 0; j++) {
                double *row = j < n ? matrix + j : columns + (j - n);
                row[4 * i] -= factor * row[4 * k];
            }
        }
    }
    for (int k = 0; k < n; k++)
        for (int j = 0; j < m; j++) columns[4 * k + j] /= matrix[4 * k + k];
    return true;
}

// One step: tries with more and more damping until the cost falls. False when it does not.
static bool descend(const Fit *fit, FfpAxis *axis, double *cost, double *damping) {
    double matrix[16], vector[4];
    differentiate(fit, axis);
    gather(fit, matrix, vector);
    for (int attempt = 0; attempt < 8; attempt++) {
        double damped[16], by[16] = {0};
        memcpy(damped, matrix, sizeof damped);
        for (int k = 0; k < fit->numbers; k++) {
            damped[5 * k] += *damping * matrix[5 * k] + 1e-12;
            by[4 * k] = vector[k];
        }
        if (!solve(fit->numbers, damped, 1, by)) return false;
        double step[FFP_AXIS_NUMBERS] = {by[0], by[4], by[8], by[12]};
        for (int k = 0; k < 4; k++) step[k] = fmin(fmax(step[k], -0.3), 0.3);
        FfpAxis moved;
        ffp_axis_move(axis, step, &moved);
        evaluate(fit, &moved, fit->there);
        const double found = mean_cost(fit, fit->there);
        if (found < *cost) {
            const bool worth = found < *cost * (1 - 1e-7);
            *axis = moved, *cost = found, *damping *= 0.3;
            memcpy(fit->here, fit->there, (size_t)fit->count * sizeof *fit->here);
            return worth;
        }
        *damping = fmax(*damping * 5, 1e-6);
    }
    return false;
}

// The inverse of the normal matrix times what a residual's square is on average.
static void estimate_covariance(const Fit *fit, const FfpAxis *axis, double covariance[16]) {
    double matrix[16], vector[4], sum = 0, weights = 0, inverse[16] = {0};
    differentiate(fit, axis);
    gather(fit, matrix, vector);
    int i = 0;
    for (int t = 0; t < fit->n_terms; t++) {
        for (int n = 0; n < fit->terms[t].count; n++, i++) {
            const double square = 1 + fit->here[i] * fit->here[i];
            if (!isfinite(square)) continue;
            const double weight = fit->terms[t].weight / (square * square);
            sum += weight * (square - 1), weights += weight;
        }
    }
    for (int k = 0; k < 4; k++) inverse[5 * k] = 1;
    const bool ok = weights > fit->numbers && solve(fit->numbers, matrix, 4, inverse);
    for (int k = 0; k < 16; k++) covariance[k] = ok ? inverse[k] * sum / (weights - fit->numbers) : INFINITY;
}

double ffp_axis_fit(FfpAxis *axis, int numbers, const FfpAxisTerm *terms, int n_terms, int steps,
                    double covariance[16]) {
    Fit fit = {.terms = terms, .n_terms = n_terms, .numbers = numbers};
    for (int t = 0; t < n_terms; t++) fit.count += terms[t].count;
    fit.here = ffp_alloc((size_t)fit.count, sizeof *fit.here);
    fit.there = ffp_alloc((size_t)fit.count, sizeof *fit.there);
    fit.slopes = ffp_alloc((size_t)fit.count * (size_t)numbers, sizeof *fit.slopes);
    evaluate(&fit, axis, fit.here);
    double cost = mean_cost(&fit, fit.here), damping = 1e-3;
    for (int i = 0; i < steps && descend(&fit, axis, &cost, &damping); i++) ffp_cancel_point();
    if (covariance != NULL) estimate_covariance(&fit, axis, covariance);
    ffp_free(fit.here), ffp_free(fit.there), ffp_free(fit.slopes);
    return cost;
}

static int ascending(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

double ffp_axis_median(const FfpAxisTerm *term, const FfpAxis *axis, int *there) {
    double *residuals = ffp_alloc((size_t)term->count + 1, sizeof *residuals);
    int n = 0;
    term->residuals(term->context, axis, residuals);
    for (int i = 0; i < term->count; i++)
        if (isfinite(residuals[i])) residuals[n++] = fabs(residuals[i]);
    qsort(residuals, (size_t)n, sizeof *residuals, ascending);
    const double median = n > 0 ? residuals[n / 2] : INFINITY;
    if (there != NULL) *there = n;
    ffp_free(residuals);
    return median;
}
