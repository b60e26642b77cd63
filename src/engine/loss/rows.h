// Sums over the rows of a picture, on all threads. Private to this room.
#ifndef FFP_LOSS_ROWS_H
#define FFP_LOSS_ROWS_H

typedef double FfpRowSum(const void *argument, int row);

// The sum over rows 0..rows-1 of what `of_row` returns for each, added up in their order: its bits do not
// depend on the number of threads. of_row writes at most what belongs to its row.
double ffp_sum_of_rows(int rows, FfpRowSum *of_row, const void *argument);

#endif
