#include "core/tensor/kernels/columns.h"

enum { COLUMNS = 32 }; // two cache lines of a row

void FFP_K(add_column_sums)(real *sum, const real *dy, const real *x, const real *mean, const real *rstd,
                            int rows, int dim) {
#pragma omp parallel for schedule(static)
    for (int first = 0; first < dim; first += COLUMNS) {
        const int count = dim - first < COLUMNS ? dim - first : COLUMNS;
        real total[COLUMNS] = {0};
        for (int t = 0; t < rows; t++) {
            const real *dy_row = dy + (size_t)t * dim + first;
            const real centre = mean ? mean[t] : 0, scale = rstd ? rstd[t] : 1;
            if (!x) {
                for (int i = 0; i < count; i++) total[i] += dy_row[i] * scale;
                continue;
            }
            const real *x_row = x + (size_t)t * dim + first;
            for (int i = 0; i < count; i++) total[i] += dy_row[i] * (x_row[i] - centre) * scale;
        }
        for (int i = 0; i < count; i++) sum[first + i] += total[i];
    }
}
