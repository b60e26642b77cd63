// The nearest neighbours of points.
#ifndef FFP_REFINE_NEIGHBOURS_H
#define FFP_REFINE_NEIGHBOURS_H

#include <stdint.h>
#include "core/base/real.h"

#define FFP_NEIGHBOURS_MAX 16

// For each of `count` points [count,3] the k nearest others, nearest first:
// neighbour[count,k], and where not NULL their squared distances. k <= FFP_NEIGHBOURS_MAX; where there are
// fewer others, -1 and infinity fill the row. Quick for points spread over the unit sphere.
void ffp_neighbours(const real *points, int64_t count, int k, int64_t *neighbour, real *squared);

#endif
