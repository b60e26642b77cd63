#include "engine/denoise/stack.h"
#include <string.h>
#include "core/base/arena.h"

// LAPACK, which OpenBLAS brings without a header for it.
void dsyev_(const char *job, const char *half, const int *n, double *a, const int *lda, double *values,
            double *work, const int *work_size, int *info);

void ffp_eigen(double *a, int n, double *values) {
    double work[34 * FFP_VALUES]; // (block size + 2) n
    const int size = (int)(sizeof work / sizeof *work);
    int info;
    dsyev_("V", "U", &n, a, &n, values, work, &size, &info); // Fortran's columns are our rows
    (void)info;                                              // not 0 only for numbers that are none
}

bool ffp_has_photographs(const FfpView *view, const int photographs[FFP_PHOTOGRAPHS]) {
    bool all = true;
    for (int p = 0; p < FFP_PHOTOGRAPHS; p++) all = all && view->images[photographs[p]].data;
    return all;
}

real *ffp_stack_new(const FfpView *view, const int photographs[FFP_PHOTOGRAPHS]) {
    const size_t pixels = (size_t)view->camera.width * (size_t)view->camera.height;
    real *stack = ffp_take(pixels * FFP_VALUES, sizeof *stack);
#pragma omp parallel for schedule(static)
    for (size_t i = 0; i < pixels; i++)
        for (size_t p = 0; p < FFP_PHOTOGRAPHS; p++)
            memcpy(stack + i * FFP_VALUES + 3 * p, view->images[photographs[p]].data + 3 * i,
                   3 * sizeof *stack);
    return stack;
}
