// A view's photographs as one list of values a pixel.
#ifndef FFP_DENOISE_STACK_H
#define FFP_DENOISE_STACK_H

#include "engine/denoise/denoise.h"

enum { FFP_VALUES = 3 * FFP_PHOTOGRAPHS };

bool ffp_has_photographs(const FfpView *view, const int photographs[FFP_PHOTOGRAPHS]);
real *ffp_stack_new(const FfpView *view,
                    const int photographs[FFP_PHOTOGRAPHS]); // [height,width,FFP_VALUES]

// Eigenvalues, rising, and unit eigenvectors of a symmetric matrix [n,n]: a becomes vectors, one a row.
// n <= FFP_VALUES. Replaces LAPACK's dsyev.
void ffp_eigen(double *a, int n, double *values);

#endif
