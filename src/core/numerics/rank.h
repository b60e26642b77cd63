// Values by their rank, without sorting them all.
#ifndef FFP_NUMERICS_RANK_H
#define FFP_NUMERICS_RANK_H

#include <stddef.h>

// Of n floats or doubles, which are reordered; n must be at least 1 for the first.
#define ffp_rank(values, n, place)                                                                           \
    FFP_OF_VALUES(values, rank)(values, n, place)                      // that of rank `place`, from 0 on
#define ffp_median(values, n) FFP_OF_VALUES(values, median)(values, n) // the upper of two; 0 of none
// The quantile below which a share of the values lies; 0 of none.
#define ffp_quantile(values, n, share) FFP_OF_VALUES(values, quantile)(values, n, share)

#define FFP_OF_VALUES(values, what)                                                                          \
    _Generic((values), float * : ffp_##what##_of_floats, double * : ffp_##what##_of_doubles)
float ffp_rank_of_floats(float *values, size_t n, size_t rank);
double ffp_rank_of_doubles(double *values, size_t n, size_t rank);
float ffp_median_of_floats(float *values, size_t n);
double ffp_median_of_doubles(double *values, size_t n);
float ffp_quantile_of_floats(float *values, size_t n, double share);
double ffp_quantile_of_doubles(double *values, size_t n, double share);

#endif
