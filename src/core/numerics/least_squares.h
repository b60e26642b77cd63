// Least squares in double: normal equations, and the minimisation of nonlinear differences.
#ifndef FFP_NUMERICS_LEAST_SQUARES_H
#define FFP_NUMERICS_LEAST_SQUARES_H

#include <stdbool.h>

// Minimises 1/2 x'Ax + b'x for symmetric positive definite A [n,n] (row-major, its lower half counts and is
// lost). False, and x is 0, where A is not.
bool ffp_solve_positive(double *a, const double *b, int n, double *x);

// Why a fit ended: another step was not worth it; none lowered the cost, though the slopes promise it, as
// where they are not those of the differences; the steps ran out.
typedef enum FfpFitEnd { FFP_END_SETTLED, FFP_END_STUCK, FFP_END_UNFINISHED } FfpFitEnd;

// The differences to minimise, and the numbers that change them.
typedef struct FfpLeastSquares {
    void *state;
    int numbers, count;
    int solved; // numbers beside these that the differences are free of, solved for where they are taken
    // The differences [count] at the state moved by `by` [numbers]; not finite: there is none.
    void (*differences)(const void *state, const double *by, double *out);
    void (*move)(void *state, const double *by);
    // The cost of the differences and, for iteratively reweighted least squares, the weight of each, 0 for
    // those to ignore. NULL: the sum of squares.
    double (*weigh)(const void *state, const double *differences, double *weights);
    // Their derivatives [numbers,count] at the state; NULL: central differences.
    void (*slopes)(const void *state, double *out);
    const double *step; // [numbers] of the central differences, either way
    int steps;          // at most
    double worth;       // the share by which a step must lower the cost for another to follow
    FfpFitEnd *end;     // NULL: it is not asked
} FfpLeastSquares;

// Moves the state downhill by the method of Levenberg (1944) and Marquardt (1963). Returns the cost reached.
// `covariance` [numbers^2] or NULL: of the numbers, from the remaining differences; all INFINITY if they do
// not determine it.
double ffp_least_squares(const FfpLeastSquares *problem, double *covariance);

#endif
