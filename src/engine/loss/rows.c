#include "engine/loss/rows.h"
#include <stdlib.h>
#include "core/base/arena.h"

double ffp_sum_of_rows(int rows, FfpRowSum *of_row, const void *argument) {
    double *sums = ffp_take((size_t)rows, sizeof *sums), sum = 0;
#pragma omp parallel for schedule(static)
    for (int y = 0; y < rows; y++) sums[y] = of_row(argument, y);
    for (int y = 0; y < rows; y++) sum += sums[y];
    ffp_free(sums);
    return sum;
}
