#include "core/numerics/least_squares.h"
#include <math.h>
#include <string.h>
#include "core/base/alloc.h"
#include "core/base/call.h"

#define DAMPING 1e-3                // at first, of the diagonal
#define LESS 0.3                    // behind a step that took
#define MORE 5.0                    // and behind one that did not
#define RIDGE 1e-12                 // for numbers that move nothing
enum { ATTEMPTS = 12, BESIDE = 4 }; // sums side by side: each would wait for its own last addition

// LAPACK's, which OpenBLAS has without a header.
void dposv_(const char *half, const int *n, const int *columns, double *a, const int *lda, double *b,
            const int *ldb, int *info);

bool ffp_solve_positive(double *a, const double *b, int n, double *x) {
    const int one = 1;
    int info;
    for (int i = 0; i < n; i++) x[i] = -b[i];
    dposv_("U", &n, &one, a, &n, x, &n, &info); // a row's lower half is a column's upper one
    bool ok = info == 0;
    for (int i = 0; i < n; i++) ok = ok && isfinite(x[i]);
    if (!ok) memset(x, 0, (size_t)n * sizeof *x);
    return ok;
}

typedef struct Fit {
    const FfpLeastSquares *problem;
    double *here, *there, *weights; // [count]
    double *slopes;                 // [numbers,count]
    double *by;                     // [numbers]
    double *matrix, *vector;        // [numbers,numbers], [numbers]: the normal equations
    double *damped;                 // [numbers,numbers]
} Fit;

static Fit fit_new(const FfpLeastSquares *problem) {
    const size_t count = (size_t)problem->count, n = (size_t)problem->numbers;
    return (Fit){.problem = problem,
                 .here = ffp_alloc(count, sizeof(double)),
                 .there = ffp_alloc(count, sizeof(double)),
                 .weights = ffp_alloc(count, sizeof(double)),
                 .slopes = ffp_alloc(count, n * sizeof(double)),
                 .by = ffp_alloc(n, sizeof(double)),
                 .matrix = ffp_alloc(n * n, sizeof(double)),
                 .vector = ffp_alloc(n, sizeof(double)),
                 .damped = ffp_alloc(n * n, sizeof(double))};
}

static void fit_free(Fit *fit) {
    ffp_free(fit->here);
    ffp_free(fit->there);
    ffp_free(fit->weights);
    ffp_free(fit->slopes);
    ffp_free(fit->by);
    ffp_free(fit->matrix);
    ffp_free(fit->vector);
    ffp_free(fit->damped);
}

static double cost_of(const Fit *fit, const double *differences) {
    const FfpLeastSquares *p = fit->problem;
    if (p->weigh) return p->weigh(p->state, differences, fit->weights);
    double sum = 0;
    for (int i = 0; i < p->count; i++) {
        sum += differences[i] * differences[i];
        fit->weights[i] = 1;
    }
    return sum;
}

// The derivatives, or central differences, 0 where either side has none.
static void differentiate(const Fit *fit) {
    const FfpLeastSquares *p = fit->problem;
    if (p->slopes) {
        p->slopes(p->state, fit->slopes);
        return;
    }
    memset(fit->by, 0, (size_t)p->numbers * sizeof *fit->by);
    for (int k = 0; k < p->numbers; k++) {
        double *slope = fit->slopes + (size_t)k * (size_t)p->count;
        fit->by[k] = p->step[k];
        p->differences(p->state, fit->by, slope);
        fit->by[k] = -p->step[k];
        p->differences(p->state, fit->by, fit->there);
        fit->by[k] = 0;
        for (int i = 0; i < p->count; i++) {
            const double difference = (slope[i] - fit->there[i]) / (2 * p->step[k]);
            slope[i] = isfinite(difference) ? difference : 0;
        }
    }
}

// The normal equations at the state as it is, from the differences there.
static void gather(const Fit *fit) {
    const int n = fit->problem->numbers, count = fit->problem->count;
    differentiate(fit);
    cost_of(fit, fit->here);
    for (int k = 0; k < n; k++) {
        const double *slope = fit->slopes + (size_t)k * (size_t)count;
        fit->vector[k] = 0;
        for (int i = 0; i < count; i++)
            if (fit->weights[i] > 0) fit->vector[k] += fit->weights[i] * slope[i] * fit->here[i];
        for (int m = 0; m <= k; m += BESIDE) {
            const double *others[BESIDE];
            double sums[BESIDE] = {0};
            for (int b = 0; b < BESIDE; b++)
                others[b] = fit->slopes + (size_t)(m + b <= k ? m + b : k) * (size_t)count;
            for (int i = 0; i < count; i++) {
                const double weighted = fit->weights[i] * slope[i];
                for (int b = 0; b < BESIDE; b++) sums[b] += weighted * others[b][i];
            }
            for (int b = 0; b < BESIDE && m + b <= k; b++)
                fit->matrix[n * k + m + b] = fit->matrix[n * (m + b) + k] = sums[b];
        }
    }
}

// By how much a step lowers the cost if the slopes are right.
static double decrease_of(const Fit *fit) {
    double sum = 0;
    for (int k = 0; k < fit->problem->numbers; k++) sum -= fit->vector[k] * fit->by[k];
    return sum;
}

// One step: tries with more and more damping until the cost falls. FFP_END_UNFINISHED where another is worth
// it.
static FfpFitEnd descend(const Fit *fit, double *cost, double *damping) {
    const FfpLeastSquares *p = fit->problem;
    const int n = p->numbers;
    double promised = INFINITY; // of the cost, by the step with least damping
    gather(fit);
    for (int attempt = 0; attempt < ATTEMPTS; attempt++) {
        memcpy(fit->damped, fit->matrix, (size_t)n * (size_t)n * sizeof *fit->damped);
        for (int k = 0; k < n; k++) fit->damped[n * k + k] += *damping * fit->matrix[n * k + k] + RIDGE;
        if (ffp_solve_positive(fit->damped, fit->vector, n, fit->by)) {
            p->differences(p->state, fit->by, fit->there);
            const double found = cost_of(fit, fit->there);
            if (attempt == 0) promised = decrease_of(fit);
            if (found < *cost) {
                const bool worth = found < *cost * (1 - p->worth);
                p->move(p->state, fit->by);
                memcpy(fit->here, fit->there, (size_t)p->count * sizeof *fit->here);
                *cost = found;
                *damping *= LESS;
                return worth ? FFP_END_UNFINISHED : FFP_END_SETTLED;
            }
        }
        *damping = fmax(*damping * MORE, 1e-6);
    }
    return promised <= p->worth * *cost ? FFP_END_SETTLED : FFP_END_STUCK;
}

// The inverse of the normal matrix, column by column, times what a difference's square is on average.
static void estimate_covariance(const Fit *fit, double *covariance) {
    const int n = fit->problem->numbers;
    double sum = 0, weights = 0;
    gather(fit);
    for (int i = 0; i < fit->problem->count; i++) {
        if (!(fit->weights[i] > 0)) continue;
        sum += fit->weights[i] * fit->here[i] * fit->here[i];
        weights += fit->weights[i];
    }
    weights -= n + fit->problem->solved;
    bool ok = weights > 0;
    for (int k = 0; k < n && ok; k++) {
        memcpy(fit->damped, fit->matrix, (size_t)n * (size_t)n * sizeof *fit->damped);
        memset(fit->vector, 0, (size_t)n * sizeof *fit->vector);
        fit->vector[k] = -1;
        ok = ffp_solve_positive(fit->damped, fit->vector, n, fit->by);
        for (int i = 0; i < n; i++) covariance[n * i + k] = fit->by[i] * sum / weights;
    }
    for (int i = 0; i < n * n && !ok; i++) covariance[i] = INFINITY;
}

double ffp_least_squares(const FfpLeastSquares *problem, double *covariance) {
    Fit fit = fit_new(problem);
    problem->differences(problem->state, fit.by, fit.here);
    double cost = cost_of(&fit, fit.here), damping = DAMPING;
    FfpFitEnd end = FFP_END_UNFINISHED;
    for (int i = 0; i < problem->steps && end == FFP_END_UNFINISHED; i++) {
        end = descend(&fit, &cost, &damping);
        ffp_cancel_point();
    }
    if (problem->end) *problem->end = end;
    if (covariance) estimate_covariance(&fit, covariance);
    fit_free(&fit);
    return cost;
}
