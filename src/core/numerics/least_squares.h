// Least squares in double: normal equations, and the descent to where differences are least.
#ifndef FFP_NUMERICS_LEAST_SQUARES_H
#define FFP_NUMERICS_LEAST_SQUARES_H

#include <stdbool.h>

// Minimises 1/2 x'Ax + b'x for symmetric positive definite A [n,n] (row-major, its lower half counts and is
// lost). False, and x is 0, where A is not.
bool ffp_solve_positive(double *a, const double *b, int n, double *x);

// Differences that are to be least, and what moves them.
typedef struct FfpLeastSquares {
    void *state;
    int numbers, count;
    // The differences [count] at the state moved by `by` [numbers]; not finite: there is none.
    void (*differences)(const void *state, const double *by, double *out);
    void (*move)(void *state, const double *by);
    // The cost of differences and, for what makes least squares of it, a weight of each, 0 where there is
    // none. NULL: the sum of squares.
    double (*weigh)(const void *state, const double *differences, double *weights);
    const double *step; // [numbers] of the numeric derivatives, either way
    int steps;          // at most
    double worth;       // the share by which a step must lower the cost for another to follow
} FfpLeastSquares;

// Moves the state downhill by the method of Levenberg (1944) and Marquardt (1963). Returns the cost reached.
// `covariance` [numbers^2] or NULL: of the numbers, from the differences left over; all INFINITY where they
// do not tell.
double ffp_least_squares(const FfpLeastSquares *problem, double *covariance);

#endif
